"""A kernel that Python calls, compiled or interpreted: its arguments, and the call itself."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from types import FunctionType
from typing import Any, NamedTuple

from numpy import ndarray

from ghostball.engine.library import cache, load, table
from ghostball.engine.library.load import Order
from ghostball.engine.library.table import (
    AT_STATUS,
    ENTERED,
    REFUSED,
    Layout,
    flat,
    kind_of,
    kind_of_result,
)

COMPILED: bool = os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0")
"""Whether kernels are compiled; else they run as the Python that they are."""

# Where the machine code of numba's puts what nobody reads: a result, which is in the table, and
# what it raises.
_UNREAD = ctypes.c_int64(), ctypes.c_void_p()
_UNREAD_AT = tuple(ctypes.byref(one) for one in _UNREAD)


class WrongArgumentError(TypeError):
    """A compiled kernel was given what it isn't compiled for."""


class Entry:
    """A kernel that Python can call.

    `function`: as it was written.
    """

    def __init__(self, function: FunctionType) -> None:
        self.function = function
        self.__name__, self.__doc__ = function.__name__, function.__doc__
        self._by_types: dict[tuple[type, ...], Code] = {}
        self._by_kinds: dict[str, Code] = {}

    def __call__(self, *arguments: Any) -> Any:
        """Call it."""
        # Adapters do so at each step: where no argument is a tuple or None, the table is made here.
        code = self._by_types.get(tuple(map(type, arguments)))
        if code is not None and code.words_of is not None:
            made = code.table_type()
            code.layout.pack(made, 0, *code.layout.head, *code.words_of(*arguments))
            raised = code.entry(*_UNREAD_AT, ctypes.byref(made))
            if made[AT_STATUS] == ENTERED:  # it has run, and must not run again
                return code.result(made, raised)
        try:
            return self.bind(*arguments)()
        except WrongArgumentError:  # they are arrays, but others than those of these types before
            return self.bind_kinds(*arguments, what="")()

    def bind(self, *arguments: Any, what: str = "") -> Callable[[], Any]:
        """Return a call with these arguments, which can be made often.

        What has to be compiled for it is compiled now, and `what` is what a message calls that.
        """
        if not COMPILED:
            return partial(self.function, *arguments)
        leaves = flat(arguments)
        types = tuple(map(type, leaves))
        code = self._by_types.get(types)
        if code is None:
            code = self._by_types[types] = self._code_for(arguments, what)
        return Call.of(code, leaves)

    def bind_kinds(self, *arguments: Any, what: str) -> Callable[[], Any]:
        """Return the same, by the kinds of the arguments, where their types have had others."""
        if not COMPILED:
            return partial(self.function, *arguments)
        return Call.of(self._code_for(arguments, what), flat(arguments))

    def __reduce__(self) -> tuple[Callable[[str], Any], tuple[str]]:
        """Pickle it by its name."""
        return table.named, (f"{self.function.__module__}:{self.__name__}",)

    def _code_for(self, arguments: tuple[Any, ...], what: str) -> Code:
        kinds = [kind_of(one) for one in arguments]
        text = table.text_of(kinds)
        if text not in self._by_kinds:
            entry = load.entry(self.function, kinds, what or self.__name__)
            self._by_kinds[text] = Code(self.function, kinds, entry)
        return self._by_kinds[text]


class Needed(NamedTuple):
    """A kernel and what it will be called with, or the like of it: so it can be made before."""

    kernel: Entry
    arguments: tuple[Any, ...]
    name: str  # what a message calls it

    @property
    def is_made(self) -> bool:
        """Whether nothing has to be compiled."""
        return not COMPILED or load.find(self.kernel.function, self.kinds) is not None

    @property
    def kinds(self) -> list[table.Kind]:
        """What the arguments are."""
        return [kind_of(one) for one in self.arguments]

    def load(self) -> Any:
        """Load its library, made where it isn't yet; return a call with the arguments."""
        return self.kernel.bind_kinds(*self.arguments, what=self.name)


IN_ONE_PROCESS = 6
"""Kernels that one process compiles at most: each adds to the memory that it takes."""


def make_all(
    needed: Iterable[Needed], jobs: int, finished: Callable[[str], None] = lambda _: None
) -> None:
    """Have the libraries made that aren't yet, by so many processes side by side.

    `finished`: called with the name of each, in any thread.

    Raises `GhostballError` where one can't be compiled.
    """
    missing = sorted((one for one in needed if not one.is_made), key=lambda one: one.name)
    folder = cache.directory()
    if folder is None:
        return  # nobody else could load them
    count = max(1, min(IN_ONE_PROCESS, -(-len(missing) // jobs)))
    # Sorted, those that take alike stand together: each process gets some of every kind.
    number = -(-len(missing) // count)
    groups = [missing[k::number] for k in range(number)]
    # Kernels of shots take longest to compile, so they come first.
    groups.sort(key=lambda group: -sum(one.name.startswith("shots") for one in group))

    def make(group: list[Needed]) -> None:
        orders = []
        for one in group:
            kernel = one.kernel.function
            orders.append(Order(kernel, one.kinds, folder / load.name_of(kernel, one.kinds)))
        load.build(orders, lambda place: finished(group[place].name))

    with ThreadPoolExecutor(jobs) as pool:
        for _ in pool.map(make, groups):
            pass
    if groups:
        cache.prune(folder)


class Code:
    """A kernel's machine code for some kinds of arguments."""

    def __init__(
        self, function: FunctionType, kinds: list[table.Kind], entry: Callable[..., int]
    ) -> None:
        self.name = function.__name__
        self.words = list(table.words_in(kinds))
        self.layout = Layout(kinds, kind_of_result(function))
        self.table_type = ctypes.c_int64 * self.layout.length
        self.entry = entry
        self.words_of = None if any(_is_apart(kind) for kind in kinds) else _words_of(kinds)

    def result(self, made: Any, raised: int) -> Any:
        """Return what the kernel has put in a table.

        Raises `IndexError` where it came to a place beyond an array.
        """
        if raised:
            raise IndexError(f"the kernel `{self.name}` came to a place beyond an array")
        return self.layout.result(made)

    def call(self, arrays: Sequence[ndarray[Any, Any]], numbers: Sequence[int], last: Last) -> Call:
        """Return a call with these arguments, of the types that it is for: faster than to bind.

        First arrays, then integers or truth values, then others; None is left out.
        """
        made = self.table_type()
        layout = self.layout
        layout.pack(made, 0, *layout.head, *map(id, arrays), *numbers, *last.words)
        return Call(self, (*arrays, *numbers, *last.values), made)


def _is_apart(kind: table.Kind) -> bool:
    """Whether an argument isn't one word."""
    return kind == "none" or kind[0] in ("tuple", "named")


def _words_of(kinds: list[table.Kind]) -> Callable[..., tuple[Any, ...]]:
    """Return what takes arguments of these kinds, one word each, and returns the words."""
    names = [f"a{k}" for k in range(len(kinds))]
    words = [
        name if isinstance(kind, str) else f"id({name})"
        for name, kind in zip(names, kinds, strict=True)
    ]
    made: Callable[..., tuple[Any, ...]] = eval(f"lambda {', '.join(names)}: ({', '.join(words)},)")
    return made


class Last:
    """The last arguments of calls that differ in the first ones only.

    `values`, `words`: without tuples and None, and what is in a table for each.
    """

    def __init__(self, *arguments: Any) -> None:
        self.values = [one for one in flat(arguments) if one is not None]
        self.words = [id(one) if isinstance(one, ndarray) else one for one in self.values]


class Call:
    """A call of a compiled kernel: its table, and what the table points to."""

    __slots__ = ("_address", "_leaves", "_table", "code")

    def __init__(self, code: Code, leaves: Sequence[Any], table: Any) -> None:
        self.code, self._leaves, self._table = code, leaves, table
        self._address = ctypes.c_void_p(ctypes.addressof(table))

    @classmethod
    def of(cls, code: Code, leaves: list[Any]) -> Call:
        """Return a call with these arguments, tuples taken apart."""
        made, last = code.table_type(), Last(*leaves)
        code.layout.pack(made, 0, *code.layout.head, *last.words)
        return cls(code, last.values, made)

    def __call__(self) -> Any:
        """Make it, and return what the kernel returns.

        Raises `WrongArgumentError` where the kernel refuses its table; then it has done nothing;
        `IndexError` where arrays are checked, and it came to a place beyond one.
        """
        raised = self.code.entry(*_UNREAD_AT, self._address)
        if self._table[AT_STATUS] != ENTERED:
            raise self._refusal(self._table[AT_STATUS])
        return self.code.result(self._table, raised)

    def _refusal(self, status: int) -> WrongArgumentError:
        if status == REFUSED:
            return WrongArgumentError(
                f"the library of the kernel `{self.code.name}` is called by another table than "
                f"version {table.VERSION} of {self.code.layout.length} words"
            )
        value = self._leaves[status - 1]
        return WrongArgumentError(
            f"argument {status} of the kernel `{self.code.name}`, tuples taken apart and None "
            f"left out, must be {self.code.words[status - 1]} in one piece, got "
            f"{kind_of(value)} with strides {value.strides}"
        )
