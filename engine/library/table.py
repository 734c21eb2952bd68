"""The table of words by which Python hands a kernel its arguments.

The one argument of a compiled kernel is the address of a table of 64-bit words: a head, what the
kernel returns, then one word for each argument. A number is its word; of an array the word is the
address of the numpy object, from which the kernel reads the address of the data and the lengths
(numpy's array interface for C, the same since numpy 1.7). So a table is made in a microsecond, and
no length in it can be wrong. Tuples are taken apart, and None has no word: both are in the types of
the arguments, for which the kernel is compiled.

The kernel checks the table before all else: a version, the number of words, and that each array is
one, of its type and its dimensions, in one piece. It reads and writes nothing otherwise.
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
"""Of the table's layout; a library that was made for another refuses the table."""

# Places in a table.
AT_VERSION = 0
AT_LENGTH = 1  # how many words there are
AT_HEAD = 2  # bytes of an object of Python's before what numpy keeps in it
AT_STATUS = 3  # one of those below, or how many arguments there are up to the first wrong one
AT_RESULT = 4  # what the kernel returns, one word for each number; then the arguments

ENTERED = 0
REFUSED = -1
"""What the status is before a kernel has changed it."""

OBJECT_HEAD = object.__basicsize__

Kind = Any
"""The type of an argument, as JSON has it.

"int", "float", "bool" or "none"; ["array", dtype, dimensions]; ["tuple", [kinds]] or ["named",
"module:class", [kinds]].
"""


def kind_of(value: Any) -> Kind:
    """Return the kind of an argument.

    Raises `TypeError` where no kernel can be given such an argument.
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
                raise TypeError(f"a kernel can't be given numbers of another byte order: {value!r}")
            fields = value.dtype.fields and [list(field) for field in value.dtype.descr]
            return ["array", fields or value.dtype.str[1:], value.ndim]
        case tuple():
            kinds = [kind_of(part) for part in value]
            if hasattr(value, "_fields"):
                return ["named", f"{type(value).__module__}:{type(value).__qualname__}", kinds]
            return ["tuple", kinds]
    raise TypeError(f"a kernel can't be given a {type(value).__name__}: {value!r}")


def kind_of_result(function: Callable[..., Any]) -> Kind:
    """Return the kind of what a kernel returns, by its annotation."""
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
    """Return kinds as a text that is the same for the same ones."""
    return json.dumps(kinds, separators=(",", ":"))


def named(place: str) -> Any:
    """Return what a text of module and name stands for."""
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)


def dtype_of(name: Any) -> np.dtype[Any]:
    """Return the type of an array's elements, as its kind names it."""
    return np.dtype(name if isinstance(name, str) else [tuple(field) for field in name])


def words_in(kinds: Iterable[Kind]) -> Iterator[Kind]:
    """Yield the kind of each word of a table, in their order."""
    for kind in kinds:
        if kind == "none":
            continue
        if kind[0] in ("tuple", "named"):
            yield from words_in(kind[-1])
        else:
            yield kind


def flat(values: Iterable[Any]) -> list[Any]:
    """Return values without tuples: what is in them in their place."""
    leaves: list[Any] = []
    for value in values:
        if isinstance(value, tuple):
            leaves += flat(value)
        else:
            leaves.append(value)
    return leaves


_FORMATS = {"float": "d", "bool": "?7x"}
"""How `struct` packs a word of these kinds; it does all others as integers."""


class Layout:
    """What lies where in the tables of a kernel that was compiled for some kinds of arguments.

    `length`: how many words a table has.
    `first`: place of the first argument.
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
        """Return what the kernel has put in a table."""
        if self._result == "int":  # most do
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
