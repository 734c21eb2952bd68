"""Fit the physics of a real table to its tracks, event by event."""
