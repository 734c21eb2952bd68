"""MuJoCo as a reference engine: contacts are dampers that reverse the approach in one time step."""
