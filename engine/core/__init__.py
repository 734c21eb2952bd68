"""Common parts of all kernels: the arrays of the state, the decorator, and tolerances.

A kernel is a compiled function, made by the decorator `core.kernel.kernel`.
"""
