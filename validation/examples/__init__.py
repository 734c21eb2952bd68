"""Short engines to begin from; they aren't installed as engines."""
