"""What goes into the machine code of a kernel: functions and constants that it reaches, by name.

Numba compiles a function's bytecode, and takes for a constant whatever a name of it stands for in
its module, or in another of our modules (`st.X`). A kernel is known by a hash of all these: who
edits a kernel waits for the compiler only where it is reached, and a comment changes nothing.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from enum import EnumMeta
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

OURS = __name__.partition(".")[0]
"""The package whose modules are looked into; of others only the name counts."""

_INLINE = "__kernel_inline__"


@dataclass(frozen=True)
class Reached:
    """What a kernel reaches.

    `functions`: itself, and all kernels below it.
    `digest`: hash of all that decides its machine code but the compiler.
    """

    functions: tuple[FunctionType, ...]
    digest: str


def mark(function: Any, inline: bool) -> None:
    """Note of a function that it is a kernel, and whether its code is written into callers."""
    setattr(function, _INLINE, inline)


def by_reference(value: Any, memory: Any) -> Any:  # noqa: ARG001 - compiled, it is used
    """Return a named tuple; in a compiled kernel its address, once it is written into `memory`.

    numba passes each array of a named tuple as seven words or more, from kernel to kernel: of the
    two dozen arrays of `Contacts` these made a third of all that is compiled.

    `memory` : (REFERENCE_WORDS,) float64; a named tuple that needs more can't be compiled.
    """
    return value


REFERENCE_WORDS = 256
"""Room for a named tuple that is passed on by its address: each array takes 7 to 11 words."""


mark(by_reference, inline=False)


def is_inline(function: FunctionType) -> bool:
    """Whether a kernel's code is written into its callers."""
    return bool(getattr(function, _INLINE, False))


def kernel_in(value: Any) -> FunctionType | None:
    """Return the function of a kernel, which Python may be able to call or not; else None."""
    function = getattr(value, "function", value)
    return function if hasattr(function, _INLINE) else None


def reached_by(function: FunctionType) -> Reached:
    """Return what a kernel reaches.

    Raises `TypeError` where it reaches something that isn't known to be constant.
    """
    functions: dict[FunctionType, None] = {}
    parts: list[Any] = []
    waiting = [function]
    while waiting:
        one = waiting.pop()
        if one in functions:
            continue
        functions[one] = None
        parts.append((one.__module__, one.__qualname__, is_inline(one), _code(one, one.__code__)))
        for name, value in names_in(one):
            below = kernel_in(value)
            if below is not None:
                parts.append((name, below.__module__, below.__qualname__))
                waiting.append(below)
            else:
                parts.append((name, _constant(value, f"`{one.__qualname__}` uses `{name}`")))
    return Reached(tuple(functions), hashlib.sha256(repr(parts).encode()).hexdigest())


def names_in(function: FunctionType) -> Iterator[tuple[str, Any]]:
    """Yield each name that a function finds outside of itself, and what it stands for.

    Of one of our modules also what it has under names that the function uses: more than it takes
    from it, perhaps, and never less.
    """
    if function.__closure__:
        raise TypeError(f"the kernel `{function.__qualname__}` is made inside another function")
    if function.__defaults__ or function.__kwdefaults__:
        raise TypeError(f"the kernel `{function.__qualname__}` has arguments that may be left out")
    names = sorted(set(_names(function.__code__)))
    for name in names:
        if name not in function.__globals__:
            continue
        value = function.__globals__[name]
        yield name, value
        if is_ours(value):
            for attribute in names:
                if hasattr(value, attribute):
                    yield f"{name}.{attribute}", getattr(value, attribute)


def is_ours(value: Any) -> bool:
    """Whether something is one of our modules."""
    return isinstance(value, ModuleType) and value.__name__.partition(".")[0] == OURS


def _names(code: CodeType) -> Iterator[str]:
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)


def _code(function: FunctionType, code: CodeType) -> Any:
    """Return what decides what a code does: not its docstring, nor where it stands."""
    constants = code.co_consts
    if constants and constants[0] == function.__doc__:
        constants = constants[1:]
    return (
        code.co_code,
        code.co_names,
        code.co_varnames,
        code.co_argcount,
        code.co_flags,
        [
            _code(function, one) if isinstance(one, CodeType) else _constant(one, code.co_name)
            for one in constants
        ],
    )


def _constant(value: Any, where: str) -> Any:
    """Return what tells a constant from another."""
    match value:
        case None | bool() | int() | float() | str() | bytes() | np.generic():
            return repr(value)
        case tuple() | list():
            return [type(value).__name__, *(_constant(one, where) for one in value)]
        case frozenset():
            return sorted(map(repr, value))
        case np.dtype():
            return repr(value.descr)
        case np.ndarray():
            return value.dtype.str, value.shape, value.tobytes()
        case EnumMeta():
            return [(one.name, repr(one.value)) for one in value]  # type: ignore[var-annotated]
        case type():
            kept = getattr(value, "_fields", None) or list(getattr(value, "__annotations__", ()))
            return value.__module__, value.__qualname__, repr(kept)
        case ModuleType() | BuiltinFunctionType() | np.ufunc():
            return value.__name__
        case FunctionType():  # of no kernel: only interpreted kernels come to it, or numba knows it
            return value.__module__, value.__qualname__
    raise TypeError(f"{where}, which isn't known to be constant: {value!r}")
