"""pybullet (Bullet 3) as a reference engine: in the plane if balls roll, otherwise in 3D."""
