"""Settings of the engine's tests: hypothesis repeats itself, so that a red test stays red."""

from __future__ import annotations

import numba
from hypothesis import HealthCheck, settings
from whole_kernels import checks_bounds, use_whole_kernels

if checks_bounds():
    use_whole_kernels()

settings.register_profile(
    "repeatable",
    deadline=None,  # the first example compiles; without JIT every example is slow
    derandomize=True,
    database=None,
    max_examples=8 if numba.config.DISABLE_JIT else 40,  # the same first ones
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("repeatable")
