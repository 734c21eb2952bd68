"""The paper's two algorithms, as printed, and their common model."""
