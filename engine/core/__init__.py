"""What all kernels share: the arrays of the state, the decorator, tolerances, kinds of events.

A kernel is a compiled function, made by the decorator `core.kernel.kernel`.
"""
