"""Engines in interpreters of their own, for what they need clashes with ours, or for a licence."""
