"""Measure errors against run times: the effect of each engine's time step."""
