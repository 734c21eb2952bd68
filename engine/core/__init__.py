"""What every kernel stands on: the arrays of the state, the compiler, tolerances, kinds of events.

A kernel is a compiled function: `kernel` has the decorator that makes one.
"""
