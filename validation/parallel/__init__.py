"""A pool of processes, and kernels compiled in it before many scenes are run."""
