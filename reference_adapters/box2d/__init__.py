"""Box2D 2.3 as a reference engine: the plane seen from above, in units of its own."""
