"""The one decorator for kernels."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar, overload

from ghostball.engine.library.entry import COMPILED, Entry
from ghostball.engine.library.reached import by_reference, mark

__all__ = ["COMPILED", "by_reference", "kernel"]

Function = TypeVar("Function", bound=Callable[..., Any])


@overload
def kernel(function: Function) -> Function: ...
@overload
def kernel(*, inline: bool = ...) -> Callable[[Function], Function]: ...
@overload
def kernel(*, entry: bool) -> Callable[[Any], Entry]: ...
def kernel(function: Any = None, *, inline: bool = False, entry: bool = False) -> Any:
    """Make a kernel of `function`: what is compiled, with all that it calls, for who calls it.

    A kernel does not allocate, does not raise (it returns a status) and uses only + - * / and
    square roots in what feeds back into the dynamics.

    `inline`: write its code into every caller. For what each event runs: a call passes each array
        of a named tuple as seven words or more, which costs more than most kernels do.
    `entry`: whether Python calls it. What it returns is then told by its annotation.

    Called by Python, one that is no entry runs as the Python that it is.
    """
    if function is None:
        return partial(kernel, inline=inline, entry=entry)
    mark(function, inline)
    return Entry(function) if entry else function
