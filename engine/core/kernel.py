"""The one decorator for kernels, and the one place that knows how they are compiled."""

from __future__ import annotations

import gc
import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from functools import partial
from typing import Any, NoReturn, TypeVar, overload

import llvmlite
import llvmlite.binding
import numba
from filelock import FileLock
from numba.core import types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher

from ghostball.engine.core.kernel_cache import KernelCache, cache_directory, locked

logger = logging.getLogger("ghostball.engine")

Function = TypeVar("Function", bound=Callable[..., Any])

_config: Any = numba.config  # its attributes are made at run time

COMPILED: bool = not _config.DISABLE_JIT
"""Whether kernels are compiled; else they run as the Python that they are."""

OPTIONS: dict[str, Any] = {
    "error_model": "numpy",  # no raising: a division by zero gives inf, as the arithmetic says
    "fastmath": False,  # no fused multiply-add, no reordering: the same bits on every machine
    "nogil": True,  # batches run in threads
    # No reference counts: kernels allocate nothing, and counting the arrays of each call took more
    # than half of the time.
    "_nrt": False,
    "no_cfunc_wrapper": True,  # nobody asks for a C function
}
_COMPILED = ".compiled"
"""Ending of the empty file that says that a variant is in the cache."""


class _InnerKernel(CPUDispatcher):
    """A kernel that only other kernels can call: no code reads arguments of Python's for it.

    Without this class a call from Python would end the process with a segmentation fault.
    """

    def __call__(self, *_: object, **__: object) -> NoReturn:
        """Refuse the call.

        Raises
        ------
        TypeError
        """
        raise TypeError(
            f"the kernel `{self.py_func.__name__}` can be called by other kernels only. If Python "
            "has to call it, mark it `@kernel(entry=True)`; a test calls what `entry_to` of "
            "tests/support/kernels.py makes of it"
        )


class _EntryKernel(CPUDispatcher):
    """A kernel that Python calls, and with which all that it calls is compiled."""

    def compile(self, signature: Any) -> Any:
        """Compile for these types of arguments, or load what was kept."""
        return _in_one_piece(super().compile, signature)


def _in_one_piece(function: Callable[[Any], Any], argument: Any) -> Any:
    """Return `function(argument)`, called from a frame of more than a megabyte.

    CPython keeps a thread's frames in pieces of 16 kB, and asks the system for the next one, or
    gives it back, whenever a call crosses an end. Some of numba's longest loops happened to call
    across one: 420 000 times for one variant, a third of the time to compile. A frame that no such
    piece can hold gets one of 2 MB, and what it calls has the rest.
    """
    return function(argument)


_in_one_piece.__code__ = _in_one_piece.__code__.replace(co_stacksize=140_000)  # words


class _InnerCode(JITCodeLibrary):
    """Code of a kernel that only other kernels call: it becomes part of theirs.

    numba optimises each kernel with all that it calls, and makes machine code of it; so a kernel is
    done as often as there are kernels above it. That took two thirds of the time to compile. Here
    both are done once, for the entry; the bits are the same, and the code is faster by a few per
    cent, since the optimiser sees the whole.
    """

    def _optimize_final_module(self) -> None:
        """Leave it to the entry."""

    def _finalize_final_module(self) -> None:
        self._finalized = True
        whole = self._get_module_for_linking()  # type: ignore[no-untyped-call]
        # What machine code is left: a place where each kernel's environment can be noted.
        self._final_module = llvmlite.binding.parse_assembly(
            "\n".join(
                f'@"{variable.name}" = common global i64 0'
                for variable in whole.global_variables
                if variable.name.startswith(_ENVIRONMENT)
            )
        )
        super()._finalize_final_module()  # type: ignore[no-untyped-call]


class _EntryCode(JITCodeLibrary):
    """Code of a kernel that Python calls, with that of all kernels below it."""

    def _optimize_final_module(self) -> None:
        """Optimise it, as one whose kernels nobody else calls.

        Then what a kernel doesn't use of what it is passed isn't passed: of some 200 words, which a
        few named tuples of arrays are, all but a dozen, in half of the calls.
        """
        for function in self._final_module.functions:
            if function.linkage == llvmlite.binding.Linkage.linkonce_odr:
                function.linkage = "internal"
        super()._optimize_final_module()  # type: ignore[no-untyped-call]


class _EntryCompiler(Compiler):
    library: Any = _EntryCode

    def compile_extra(self, function: Callable[..., Any]) -> Any:
        """Compile, as numba does, but into a library of another kind."""
        self.state.library = self.library(self.state.targetctx.codegen(), function.__qualname__)
        self.state.library.enable_object_caching()
        return super().compile_extra(function)  # type: ignore[no-untyped-call]


class _InnerCompiler(_EntryCompiler):
    library: Any = _InnerCode


_ENVIRONMENT = "_ZN08NumbaEnv"
"""How the names begin of the variables by which numba notes a function's environment."""


@overload
def kernel(function: Function) -> Function: ...
@overload
def kernel(*, inline: bool = ..., entry: bool = ...) -> Callable[[Function], Function]: ...
def kernel(function: Any = None, *, inline: bool = False, entry: bool = False) -> Any:
    """Compile `function` when it is first called, and keep the machine code for later processes.

    A kernel does not allocate, does not raise (it returns a status) and uses only + - * / and
    square roots in what feeds back into the dynamics.

    Parameters
    ----------
    function : callable
    inline : bool
        Write its code into every caller. For what each event runs: a call passes each array of a
        named tuple as seven words or more, which costs more than most kernels do.
    entry : bool
        Whether Python may call it. The code that reads Python's arguments costs a third of the time
        that a kernel takes to compile, and all but a few kernels are called by kernels alone.

    Notes
    -----
    Python's call of a kernel that is no entry raises TypeError, where kernels are compiled.
    """
    if function is None:
        return partial(kernel, inline=inline, entry=entry)
    if _config.DISABLE_JIT:
        return function
    options = {**OPTIONS, "forceinline": inline, "no_cpython_wrapper": not entry}
    options["pipeline_class"] = _EntryCompiler if entry else _InnerCompiler
    dispatcher = numba.njit(**options)(function)
    directory = cache_directory()
    if directory is not None:
        # Entries lie in folders of their own: numba finds what it kept by the function alone, not
        # by its options.
        dispatcher._cache = KernelCache(function, directory, "entries" if entry else "inner")
    dispatcher.__class__ = _EntryKernel if entry else _InnerKernel
    return _without_literals(dispatcher)


def _without_literals(dispatcher: Any) -> Any:
    """Let a caller's constant be an argument like any other.

    numba would compile a kernel anew for each constant that a caller passes, and all that it calls:
    twice the time for nothing.
    """
    resolve = dispatcher.get_call_template
    unliteral: Any = types.unliteral
    dispatcher.get_call_template = lambda args, kws: resolve(
        tuple(unliteral(kind) for kind in args),
        {name: unliteral(kind) for name, kind in kws.items()},
    )
    return dispatcher


def compiled(variant: str = "") -> bool:
    """Whether a variant of these very kernels is in the cache, so that it starts fast.

    "" is any variant.
    """
    if _config.DISABLE_JIT:
        return True
    directory = cache_directory()
    return directory is not None and any(directory.glob(f"{variant or '*'}{_COMPILED}"))


@contextmanager
def compiling(variant: str) -> Iterator[None]:
    """Say so where what is done here will compile a variant of the kernels, and note that it did.

    At warning level: a program that never configured logging still shows it on stderr. Of several
    processes that need the same variant one compiles it; the others wait, and load it.
    """
    if compiled(variant):
        yield
        return
    directory = cache_directory()
    if directory is None:
        with _announced(variant):
            yield
        return
    with locked(directory):
        lock = FileLock(directory / f"{variant}.lock")
    with lock:
        # Another process may have compiled it while this one waited.
        with nullcontext() if compiled(variant) else _announced(variant):
            yield
        with locked(directory):
            (directory / f"{variant}{_COMPILED}").touch()


@contextmanager
def _announced(variant: str) -> Iterator[None]:
    """Say that a variant is being compiled, and look for no garbage meanwhile.

    The compiler makes millions of objects and keeps them: looking through them takes a tenth of its
    time.
    """
    logger.warning(
        "compiling the engine's kernels (%s) for this machine, once; it may take half a minute ...",
        variant,
    )
    collected = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collected:
            gc.enable()
