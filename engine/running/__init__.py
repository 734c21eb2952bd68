"""Python around the kernels: from a scene to arrays, which variant, a run and its logs.

`from_scene` makes the arrays, `driver` and `threads` run a shot, and many; `skips` and
`variants` decide what is left out of the work, and of the compiled code.
"""
