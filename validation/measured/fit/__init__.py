"""Physics fitted to the tracks of a real table, event by event."""
