"""Decorator of all kernels."""

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
    """Return `function` as a kernel, which is compiled together with the kernels that call it.

    A kernel does not allocate and does not raise; it returns a status instead. Numbers that affect
    the dynamics are computed with + - * / and square roots only.

    `inline`: insert the code into every caller. This is for kernels that every event runs: a call
        passes each array of a named tuple as seven words or more, which takes longer than most
        kernels.
    `entry`: whether Python calls the compiled kernel. The annotation gives the type of its result.

    A kernel that is no entry runs as ordinary Python if Python calls it.
    """
    if function is None:
        return partial(kernel, inline=inline, entry=entry)
    mark(function, inline)
    return Entry(function) if entry else function
