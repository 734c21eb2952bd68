"""Box2D 3 as a reference engine: the top view of the table."""
