"""Settings of the engine's tests."""

from __future__ import annotations

from kernels import checks_bounds, use_few_kernels

if checks_bounds():
    use_few_kernels()
