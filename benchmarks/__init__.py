"""Benchmarks of Ghostball's engine. They are part of the repository, not of the package."""
