"""Kernels as shared libraries: who compiles them, where they are kept, and how Python calls one.

A kernel that Python calls is compiled ahead of its use, with all that it calls, into a library of
its own, and called by ctypes. So who uses the engine needs no compiler: libraries come with the
package (`shipped`), and numba is loaded only where one has to be made, in a process of its own
(`build`). `table` says how arguments are handed over, `reached` what goes into the machine code,
`load` which library fits.
"""
