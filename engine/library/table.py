"""The table of words with which Python passes arguments to a kernel.

The one argument of a compiled kernel is the address of a table of 64-bit words: a head, the result,
then one word per argument. The word of a number is the number; the word of an array is the address
of the numpy object, from which the kernel reads the address of the data and the lengths (numpy's C
structures, unchanged since numpy 1.7). A table is therefore made in a microsecond, and no length in
it can be wrong. None has no word, because the kernel is compiled for the types of its arguments.

The kernel first checks the table: its version, its number of words, and that each array has the
right type and number of dimensions and is contiguous. If a check fails, it reads and writes nothing
else.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np

VERSION = 2
"""Version of the table's layout; a library for another version refuses the table."""

# Indices into a table.
AT_VERSION = 0
AT_LENGTH = 1  # number of words
AT_HEAD = 2  # size of the head of a Python object, after which numpy's fields follow [bytes]
AT_STATUS = 3  # ENTERED, REFUSED, or the number of the first wrong argument, from 1
AT_RESULT = 4  # the result, if the kernel returns a number
AT_FIRST = 5  # the first argument

ENTERED = 0
REFUSED = -1
"""The status before the kernel has changed it."""

OBJECT_HEAD = object.__basicsize__

Kind = Any
"""The type of an argument, as stored in JSON.

"int", "float", "bool", "none", or ["array", dtype, dimensions].
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
    raise TypeError(f"a kernel can't take a {type(value).__name__}: {value!r}")


def kind_of_result(function: Callable[..., Any]) -> Kind:
    """Return the kind of a kernel's result, from its annotation."""
    hint = function.__annotations__["return"]
    hint = eval(hint, function.__globals__) if isinstance(hint, str) else hint
    kind = {None: "none", bool: "bool", int: "int", float: "float"}.get(hint)
    if kind is None:
        raise TypeError(f"a kernel can't return {hint!r} to Python")
    return kind


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


_FORMATS = {"float": "d", "bool": "?7x"}
"""The `struct` formats of words of these kinds; all other words are integers."""


class Layout:
    """The layout of the tables of a kernel that is compiled for some kinds of arguments.

    `words`: the kind of each argument that has a word, in order.
    `length`: number of words in a table.
    `pack`: packs all words into a table.
    """

    def __init__(self, kinds: list[Kind], result: Kind) -> None:
        self.words = [kind for kind in kinds if kind != "none"]
        self.length = AT_FIRST + len(self.words)
        formats = "".join(_FORMATS.get(str(kind), "q") for kind in self.words)
        self.pack = struct.Struct(f"{AT_FIRST}q{formats}").pack_into
        self.head = (VERSION, self.length, OBJECT_HEAD, REFUSED, 0)
        self._result = result
        self._unpack = struct.Struct(_FORMATS.get(result, "q")).unpack_from

    def result(self, table: Any) -> Any:
        """Return the result that the kernel has put in a table."""
        if self._result == "int":  # the result of most kernels
            return table[AT_RESULT]
        return None if self._result == "none" else self._unpack(table, 8 * AT_RESULT)[0]
