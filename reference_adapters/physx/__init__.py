"""PhysX 5 on the processor, through SAPIEN, as a reference engine."""
