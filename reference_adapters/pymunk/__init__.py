"""Pymunk (Chipmunk) as a reference engine: the top view of the table."""
