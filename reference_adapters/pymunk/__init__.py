"""Pymunk (Chipmunk) as a reference engine: the plane seen from above."""
