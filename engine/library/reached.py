"""Everything that determines the machine code of a kernel: functions and constants, by name.

numba compiles a function's bytecode, and treats as a constant every value that a name has in the
function's module or in another of our modules (`st.X`). A hash of all these identifies a kernel. An
edit therefore causes compilation only of kernels that use the edited code, and comments have no
effect.
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
"""The package whose modules are inspected; other modules count by their names only."""

_INLINE = "__kernel_inline__"


@dataclass(frozen=True)
class Reached:
    """The functions and constants that a kernel depends on.

    `functions`: the kernel itself, and all kernels below it.
    `digest`: hash of everything that determines its machine code, except the compiler.
    """

    functions: tuple[FunctionType, ...]
    digest: str


def mark(function: Any, inline: bool) -> None:
    """Mark a function as a kernel, and store whether its code is inlined into callers."""
    setattr(function, _INLINE, inline)


def by_reference(value: Any, memory: Any) -> Any:  # noqa: ARG001 - compiled kernels use it
    """Return a named tuple; in a compiled kernel, write it into `memory` and return its address.

    numba passes each array of a named tuple as seven words or more from kernel to kernel; passing
    the two dozen arrays of `Contacts` was a third of all compiled code.

    `memory` : (REFERENCE_WORDS,) float64; a named tuple that needs more can't be compiled.
    """
    return value


REFERENCE_WORDS = 256
"""Words for a named tuple that is passed by address: each array takes 7 to 11 words."""


mark(by_reference, inline=False)


def is_inline(function: FunctionType) -> bool:
    """Return whether a kernel's code is inlined into its callers."""
    return bool(getattr(function, _INLINE, False))


def kernel_in(value: Any) -> FunctionType | None:
    """Return the Python function of a kernel, or None if the value isn't a kernel."""
    function = getattr(value, "function", value)
    return function if hasattr(function, _INLINE) else None


def reached_by(function: FunctionType) -> Reached:
    """Return everything that a kernel depends on.

    Raises `TypeError` if that includes a value that isn't known to be constant.
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
    """Yield each global name that a function uses, and its value.

    If the value is one of our modules, also yield its attributes with names that occur in the
    function: possibly more than the function uses, but never fewer.
    """
    if function.__closure__:
        raise TypeError(f"the kernel `{function.__qualname__}` is defined inside another function")
    if function.__defaults__ or function.__kwdefaults__:
        raise TypeError(f"the kernel `{function.__qualname__}` has optional arguments")
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
    """Return whether a value is one of our modules."""
    return isinstance(value, ModuleType) and value.__name__.partition(".")[0] == OURS


def _names(code: CodeType) -> Iterator[str]:
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)


def _code(function: FunctionType, code: CodeType) -> Any:
    """Return everything that determines what code does: without its docstring and its location."""
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
    """Return a value that distinguishes a constant from all other constants."""
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
        case FunctionType():  # not a kernel: used by interpreted kernels only, or known to numba
            return value.__module__, value.__qualname__
    raise TypeError(f"{where}, which isn't known to be constant: {value!r}")
