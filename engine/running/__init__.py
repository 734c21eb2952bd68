"""Python code around the kernels: arrays of a scene, choice of the kernel, runs and their logs.

`from_scene` and `obstacle_rows` make the arrays; `driver` runs one shot, `threads` many. `skips`
decides which work is skipped, `variants` which of the two compiled kernels a scene needs.
"""
