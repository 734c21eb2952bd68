"""The paper's own two algorithms, as printed, and what they share."""
