"""pybullet (Bullet 3) as a reference engine: in the plane where balls roll, else in space."""
