"""Benchmarks of our own engine, which the repository has and the installed package hasn't."""
