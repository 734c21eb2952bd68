"""Box2D 2.3 as a reference engine: the top view of the table, with a separate unit of length."""
