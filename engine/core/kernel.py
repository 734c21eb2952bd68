"""The one decorator for kernels, and the one place that knows how and where they are compiled.

A kernel is a function that numba compiles to machine code. numba keeps that beside the source file
and looks only at *that* file to decide whether it is fresh: edit a callee in another file, or a
constant, and callers stay stale. So the cache lives in a directory whose name is a hash of
everything that goes into the machine code: the sources of this package, the versions of numba,
llvmlite and numpy, and the flags. A changed source means another directory, and nothing stale can
be found.
"""

from __future__ import annotations

import gc
import hashlib
import logging
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from functools import cache, partial
from pathlib import Path
from typing import Any, NoReturn, TypeVar, overload

import llvmlite
import llvmlite.binding
import numba
import numpy as np
import platformdirs
from filelock import FileLock
from numba.core import types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher

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
FLAGS = ("BOUNDSCHECK", "OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "CPU_NAME", "CPU_FEATURES")
"""Settings of numba that change the machine code."""

_COMPILED = ".compiled"
"""Ending of the empty file that says that a variant is in the cache."""

KEPT_CACHES = 12
"""Caches of other sources or flags that are kept, each of some 30 MB.

Enough for a few checkouts beside each other: each has one for its kernels, one for those that check
bounds, and small ones for copies of the engine that tests compile.
"""


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

    numba optimises each kernel with all that it calls, and makes machine code of it: what lies deep
    as often as there are kernels above it. That took two thirds of the time to compile. Here both
    are done once, for the entry; the bits are the same, and the code is quicker by a few per cent,
    since the optimiser sees the whole.
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
    directory = cache_directory()
    if directory is None:
        dispatcher = numba.njit(**options)(function)
    else:
        # Entries lie apart: numba finds what it kept by the function alone, not by its options.
        directory = directory / "entries" if entry else directory
        # The directory is read when caching is enabled, that is while the decorator runs.
        previous, _config.CACHE_DIR = _config.CACHE_DIR, str(directory)
        try:
            dispatcher = numba.njit(cache=True, **options)(function)
        finally:
            _config.CACHE_DIR = previous
        _save_one_at_a_time(dispatcher, directory)
    dispatcher.__class__ = _EntryKernel if entry else _InnerKernel
    return _without_literals(dispatcher)


def _save_one_at_a_time(dispatcher: Any, directory: Path) -> None:
    """Let no two processes keep what they compiled of one kernel at the same time.

    numba reads the kernel's index, picks the next free name, and writes index and machine code
    under it. Of two that do so side by side, each for its own variant, one's index may be left with
    the other's code: from then on that variant can't be loaded, nor compiled.
    """
    file = dispatcher._cache._cache_file
    save = file.save

    def save_alone(key: Any, data: Any) -> None:
        with FileLock(directory / "saving.lock"):
            save(key, data)

    file.save = save_alone


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


@cache
def cache_directory() -> Path | None:
    """Directory of this package's compiled kernels; made, and old ones removed, on first use.

    None where it can't be written: kernels are then compiled in each process anew, and a warning
    says so.
    """
    root = cache_root()
    directory = root / cache_key()
    try:
        directory.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=directory).close()
        os.utime(directory)
        _prune(root, keep=directory)
    except OSError as error:
        logger.warning(
            "compiled kernels can't be kept in %s: %s. Every run will compile them again; set "
            "GHOSTBALL_CACHE_DIR to a directory that can be written",
            root,
            error.strerror or type(error).__name__,
        )
        return None
    return directory


def cache_root() -> Path:
    """Directory that holds the caches; GHOSTBALL_CACHE_DIR in the environment overrides it."""
    chosen = os.environ.get("GHOSTBALL_CACHE_DIR")
    return Path(chosen) if chosen else Path(platformdirs.user_cache_dir("ghostball")) / "kernels"


def cache_key() -> str:
    """Hash of all that decides the machine code: sources, versions, flags, the processor.

    And of where the sources lie, since numba keeps what it compiles by their paths: of two equal
    checkouts each compiles, and says so. The flags are in it because a warm numba cache ignores
    those of bounds checks and of the optimiser. The processor is in it because numba compiles anew
    for another one, without a word: where machines share a home, or a CI restores a cache.
    """
    package = Path(__file__).resolve().parent.parent
    digest = hashlib.sha256(os.fsencode(package))
    for path in sorted(package.rglob("*.py")):
        digest.update(bytes(path.relative_to(package)) + b"\0" + path.read_bytes())
    flags = [getattr(_config, name) for name in FLAGS]
    versions = [numba.__version__, llvmlite.__version__, np.__version__]
    digest.update(repr((flags, OPTIONS, versions, _processor())).encode())
    return digest.hexdigest()[:20]


def _processor() -> tuple[str, str]:
    """Return the processor's name and features, as the compiler calls them."""
    features = llvmlite.binding.get_host_cpu_features()
    return llvmlite.binding.get_host_cpu_name(), features.flatten()


def compiled(variant: str = "") -> bool:
    """Whether a variant of these very kernels is in the cache, so that it starts quickly.

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
    with FileLock(directory / f"{variant}.lock"):
        # Another process may have compiled it while this one waited.
        with nullcontext() if compiled(variant) else _announced(variant):
            yield
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


def _prune(root: Path, keep: Path) -> None:
    others = [path for path in root.iterdir() if path.is_dir() and path != keep]
    others.sort(key=lambda path: path.stat().st_mtime, reverse=True)
    for stale in others[KEPT_CACHES:]:
        # Another process may remove the same one; whoever comes second has nothing left to do.
        shutil.rmtree(stale, ignore_errors=True)
