"""Box2D 3 as a reference engine: the plane seen from above."""
