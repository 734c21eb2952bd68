"""What is measured of a run, the limits that it must keep, and the verdict on it."""
