"""Metrics of a run, the limits on them, and the verdict."""
