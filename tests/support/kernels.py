"""Kernels that tests call, though only other kernels do in the engine."""

from __future__ import annotations

from functools import cache
from typing import Any

from ghostball.engine.core.kernel import kernel


@cache
def entry_to(inner: Any) -> Any:
    """Return a kernel that does what `inner` does, and that Python can call.

    An entry, or what isn't compiled, is returned as it is.
    """
    function = getattr(inner, "py_func", None)
    if function is None or not inner.targetoptions["no_cpython_wrapper"]:
        return inner
    return kernel(entry=True)(function)
