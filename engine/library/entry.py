"""Kernels that Python calls, compiled or interpreted: their arguments, and the call itself."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from types import FunctionType
from typing import Any, NamedTuple

from ghostball.engine.library import cache, load, table
from ghostball.engine.library.load import Order
from ghostball.engine.library.table import (
    AT_STATUS,
    ENTERED,
    REFUSED,
    Layout,
    kind_of,
    kind_of_result,
)

COMPILED: bool = os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0")
"""Whether kernels are compiled; otherwise kernels run as ordinary Python."""

# Where the machine code writes two values that are not used: numba's return value (results are in
# the table), and an exception.
_UNREAD = ctypes.c_int64(), ctypes.c_void_p()
_UNREAD_AT = tuple(ctypes.byref(one) for one in _UNREAD)


class WrongArgumentError(TypeError):
    """A compiled kernel was called with arguments for which it isn't compiled."""


class Entry:
    """A kernel that Python can call.

    `function`: the Python function.
    """

    def __init__(self, function: FunctionType) -> None:
        self.function = function
        self.__name__, self.__doc__ = function.__name__, function.__doc__
        self._by_types: dict[tuple[type, ...], Code] = {}
        self._by_kinds: dict[str, Code] = {}

    def __call__(self, *arguments: Any) -> Any:
        """Call the kernel."""
        # Adapters call kernels at each step, so the table is made here, without a `Call`.
        code = self._by_types.get(tuple(map(type, arguments)))
        if code is not None:
            made = code.packed(arguments)
            raised = code.entry(*_UNREAD_AT, ctypes.byref(made))
            if made[AT_STATUS] == ENTERED:  # the kernel has run, and must not run twice
                return code.result(made, raised)
            # Arrays with other elements or dimensions than in the first call.
            return Call(self.code_for(arguments), arguments)()
        return self.bind(*arguments)()

    def bind(self, *arguments: Any) -> Callable[[], Any]:
        """Return a call with these arguments, which can be made many times.

        A missing kernel is compiled now. Later calls with arguments of the same Python types need
        arrays with the same elements and dimensions as in the first call.
        """
        if not COMPILED:
            return partial(self.function, *arguments)
        types = tuple(map(type, arguments))
        code = self._by_types.get(types)
        if code is None:
            code = self._by_types[types] = self.code_for(arguments)
        return Call(code, arguments)

    def __reduce__(self) -> tuple[Callable[[str], Any], tuple[str]]:
        """Pickle the kernel by its name."""
        return table.named, (f"{self.function.__module__}:{self.__name__}",)

    def code_for(self, arguments: tuple[Any, ...], what: str = "") -> Code:
        """Return the machine code for arguments like these, after compiling it if necessary.

        Messages call the kernel `what`.
        """
        kinds = [kind_of(one) for one in arguments]
        text = table.text_of(kinds)
        if text not in self._by_kinds:
            entry = load.entry(self.function, kinds, what or self.__name__)
            self._by_kinds[text] = Code(self.function, kinds, entry)
        return self._by_kinds[text]


class Needed(NamedTuple):
    """A kernel with arguments like those of later calls, so that it can be compiled in advance."""

    kernel: Entry
    arguments: tuple[Any, ...]
    name: str  # the name in messages

    @property
    def is_made(self) -> bool:
        """Whether the library exists already."""
        return not COMPILED or load.find(self.kernel.function, self.kinds) is not None

    @property
    def kinds(self) -> list[table.Kind]:
        """The kinds of the arguments."""
        return [kind_of(one) for one in self.arguments]

    def load(self) -> None:
        """Load the library, after compiling it if necessary."""
        if COMPILED:
            self.kernel.code_for(self.arguments, self.name)


KERNELS_PER_PROCESS = 6
"""Largest number of kernels for one process: each adds to the memory that the process needs."""


def make_all(
    needed: Iterable[Needed], jobs: int, finished: Callable[[str], None] = lambda _: None
) -> None:
    """Compile all missing libraries, in `jobs` processes side by side.

    `finished`: called with the name of each kernel, in any thread.

    Raises `GhostballError` if a kernel can't be compiled.
    """
    missing = sorted((one for one in needed if not one.is_made), key=lambda one: one.name)
    folder = cache.directory()
    if folder is None:
        return  # without a folder, no other process could load the libraries
    count = max(1, min(KERNELS_PER_PROCESS, -(-len(missing) // jobs)))
    # Kernels with similar compile times are adjacent after sorting, so each process gets a mixture.
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
    """The machine code of a kernel for some kinds of arguments."""

    def __init__(
        self, function: FunctionType, kinds: list[table.Kind], entry: Callable[..., int]
    ) -> None:
        self.name = function.__name__
        self.layout = Layout(kinds, kind_of_result(function))
        self.entry = entry
        self._table_type = ctypes.c_int64 * self.layout.length
        self._words_of = _words_of(kinds)

    def packed(self, arguments: Sequence[Any]) -> Any:
        """Return a table with these arguments, which must exist as long as the table."""
        made, layout = self._table_type(), self.layout
        layout.pack(made, 0, *layout.head, *self._words_of(*arguments))
        return made

    def result(self, made: Any, raised: int) -> Any:
        """Return the result that the kernel has put in a table.

        Raises `IndexError` if the kernel used an index outside an array.
        """
        if raised:
            raise IndexError(f"the kernel `{self.name}` used an index outside an array")
        return self.layout.result(made)


def _words_of(kinds: list[table.Kind]) -> Callable[..., tuple[Any, ...]]:
    """Return a function that maps arguments of these kinds to the words of a table."""
    names = [f"a{k}" for k in range(len(kinds))]
    words = [
        name if isinstance(kind, str) else f"id({name})"
        for name, kind in zip(names, kinds, strict=True)
        if kind != "none"
    ]
    made: Callable[..., tuple[Any, ...]] = eval(f"lambda {', '.join(names)}: ({', '.join(words)},)")
    return made


class Call:
    """A call of a compiled kernel: its table, and references to the arrays it points to."""

    __slots__ = ("_address", "_arguments", "_table", "code")

    def __init__(self, code: Code, arguments: Sequence[Any]) -> None:
        self.code, self._arguments, self._table = code, arguments, code.packed(arguments)
        self._address = ctypes.c_void_p(ctypes.addressof(self._table))

    def __call__(self) -> Any:
        """Call the kernel, and return its result.

        Raises `WrongArgumentError` if the kernel refuses its table, in which case it has done
        nothing, and `IndexError` if it used an index outside an array, with bounds checks on.
        """
        raised = self.code.entry(*_UNREAD_AT, self._address)
        if self._table[AT_STATUS] != ENTERED:
            raise self._refusal(self._table[AT_STATUS])
        return self.code.result(self._table, raised)

    def _refusal(self, status: int) -> WrongArgumentError:
        name, layout = self.code.name, self.code.layout
        if status == REFUSED:
            return WrongArgumentError(
                f"the library of the kernel `{name}` needs another table than version "
                f"{table.VERSION} with {layout.length} words"
            )
        value = [one for one in self._arguments if one is not None][status - 1]
        return WrongArgumentError(
            f"argument {status} of the kernel `{name}` (without None) must be a contiguous "
            f"{layout.words[status - 1]}, got {kind_of(value)} with strides {value.strides}"
        )
