"""Balls that friction holds together: who they are, their forces, the steps they move in."""
