"""The command `ghostball`: a thin layer over `validation`, `reports` and the engines.

Its modules import the packages that they call inside functions: `ghostball --help` must not wait
for numpy and the engines.
"""
