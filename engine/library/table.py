"""The table of words with which Python passes arguments to a kernel.

The one argument of a compiled kernel is the address of a table of 64-bit words: a head, the result,
then one word per argument. The word of a number is the number; the word of an array is the address
of the numpy object, from which the kernel reads the address of the data and the lengths (numpy's C
structures, unchanged since numpy 1.7). A table is therefore made in a microsecond, and no length in
it can be wrong. Tuples are flattened, and None has no word: both belong to the types of the
arguments, for which the kernel is compiled.

The kernel first checks the table: its version, its number of words, and that each array has the
right type and number of dimensions and is contiguous. If a check fails, it reads and writes nothing
else.
"""

from __future__ import annotations

import json
import struct
import typing
from collections.abc import Callable, Iterable, Iterator
from importlib import import_module
from types import NoneType
from typing import Any

import numpy as np

VERSION = 1
"""Version of the table's layout; a library for another version refuses the table."""

# Indices into a table.
AT_VERSION = 0
AT_LENGTH = 1  # number of words
AT_HEAD = 2  # size of the head of a Python object, after which numpy's fields follow [bytes]
AT_STATUS = 3  # ENTERED, REFUSED, or the number of the first wrong argument, from 1
AT_RESULT = 4  # the result, one word per number; then the arguments

ENTERED = 0
REFUSED = -1
"""The status before the kernel has changed it."""

OBJECT_HEAD = object.__basicsize__

Kind = Any
"""The type of an argument, as stored in JSON.

"int", "float", "bool" or "none"; ["array", dtype, dimensions]; ["tuple", [kinds]] or ["named",
"module:class", [kinds]].
"""


def kind_of(value: Any) -> Kind:
    """Return the kind of an argument.

    Raises `TypeError` if no kernel can take such an argument.
    """
    match value:
        case None:
            return "none"
        case bool() | np.bool_():
            return "bool"
        case int() | np.integer():
            return "int"
        case float():
            return "float"
        case np.ndarray():
            if not value.dtype.isnative:
                raise TypeError(f"a kernel can't take numbers with another byte order: {value!r}")
            fields = value.dtype.fields and [list(field) for field in value.dtype.descr]
            return ["array", fields or value.dtype.str[1:], value.ndim]
        case tuple():
            kinds = [kind_of(part) for part in value]
            if hasattr(value, "_fields"):
                return ["named", f"{type(value).__module__}:{type(value).__qualname__}", kinds]
            return ["tuple", kinds]
    raise TypeError(f"a kernel can't take a {type(value).__name__}: {value!r}")


def kind_of_result(function: Callable[..., Any]) -> Kind:
    """Return the kind of a kernel's result, from its annotation."""
    hint = function.__annotations__["return"]
    return _kind_of_hint(eval(hint, function.__globals__) if isinstance(hint, str) else hint)


def _kind_of_hint(hint: Any) -> Kind:
    simple = {NoneType: "none", None: "none", bool: "bool", int: "int", float: "float"}
    if hint in simple:
        return simple[hint]
    if hasattr(hint, "_fields"):
        kinds = [_kind_of_hint(part) for part in typing.get_type_hints(hint).values()]
        return ["named", f"{hint.__module__}:{hint.__qualname__}", kinds]
    if typing.get_origin(hint) is tuple:
        return ["tuple", [_kind_of_hint(part) for part in typing.get_args(hint)]]
    raise TypeError(f"a kernel can't return {hint!r} to Python")


def text_of(kinds: Kind) -> str:
    """Return kinds as text; equal kinds have equal texts."""
    return json.dumps(kinds, separators=(",", ":"))


def named(place: str) -> Any:
    """Return the object that a text "module:name" refers to."""
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)


def dtype_of(name: Any) -> np.dtype[Any]:
    """Return the type of an array's elements from its kind."""
    return np.dtype(name if isinstance(name, str) else [tuple(field) for field in name])


def words_in(kinds: Iterable[Kind]) -> Iterator[Kind]:
    """Yield the kind of each argument word of a table, in order."""
    for kind in kinds:
        if kind == "none":
            continue
        if kind[0] in ("tuple", "named"):
            yield from words_in(kind[-1])
        else:
            yield kind


def flat(values: Iterable[Any]) -> list[Any]:
    """Return values with tuples replaced by their elements, at any depth."""
    leaves: list[Any] = []
    for value in values:
        if isinstance(value, tuple):
            leaves += flat(value)
        else:
            leaves.append(value)
    return leaves


_FORMATS = {"float": "d", "bool": "?7x"}
"""The `struct` formats of words of these kinds; all other words are integers."""


class Layout:
    """The layout of the tables of a kernel that is compiled for some kinds of arguments.

    `length`: number of words in a table.
    `first`: index of the first argument.
    `pack`: packs all words into a table.
    """

    def __init__(self, kinds: list[Kind], result: Kind) -> None:
        results = list(words_in([result]))
        self.first = AT_RESULT + len(results)
        numbers = [_FORMATS.get(kind, "q") for kind in map(str, words_in(kinds))]
        self.length = self.first + len(numbers)
        self.pack = struct.Struct(f"{self.first}q{''.join(numbers)}").pack_into
        self.head = (VERSION, self.length, OBJECT_HEAD, REFUSED, *(0 for _ in results))
        self._result = result
        self._unpack = struct.Struct(
            "".join("d" if kind == "float" else "q" for kind in results)
        ).unpack_from

    def result(self, table: Any) -> Any:
        """Return the result that the kernel has put in a table."""
        if self._result == "int":  # the result of most kernels
            return table[AT_RESULT]
        return _made(self._result, iter(self._unpack(table, 8 * AT_RESULT)))


def _made(kind: Kind, words: Iterator[Any]) -> Any:
    if kind == "none":
        return None
    if kind == "bool":
        return bool(next(words))
    if isinstance(kind, str):
        return next(words)
    parts = tuple(_made(part, words) for part in kind[-1])
    return parts if kind[0] == "tuple" else named(kind[1])(*parts)
