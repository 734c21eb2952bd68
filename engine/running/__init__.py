"""Python around the kernels: from a scene to arrays, which variant, a run and its logs."""
