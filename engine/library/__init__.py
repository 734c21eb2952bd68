"""Kernels as shared libraries: how they are compiled, where they are stored, how Python calls them.

A kernel that Python calls is compiled before its use, together with all kernels below it, into a
library of its own, and called with ctypes. Users therefore need no compiler: the package contains
libraries (`shipped`), and numba is imported only if a library has to be made, in a separate process
(`build`). `table` describes how arguments are passed, `reached` what determines the machine code,
`load` how the library of a kernel is found.
"""
