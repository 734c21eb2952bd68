"""Newton as a reference engine: spheres in the plane of the table, in single precision."""
