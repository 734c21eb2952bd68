"""Where compiled kernels are kept.

A kernel is a function that numba compiles to machine code. numba keeps that, and looks only at the
function's *own* file to decide whether it is fresh: edit a callee in another file, or a constant,
and callers stay stale. So the cache lies in a directory whose name is a hash of everything that
goes into the machine code: the sources of this package, what kernels take from the model, the
versions of numba, llvmlite and numpy, and the flags. A changed source means another directory, and
nothing stale can be found. Kernels of other packages lie there too, in folders named by a hash of
the sources beside them.
"""

from __future__ import annotations

import hashlib
import inspect
import logging
import os
import re
import shutil
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import llvmlite.binding
import numba
import numpy as np
from filelock import FileLock, Timeout
from numba.core.caching import CompileResultCacheImpl, FunctionCache, _CacheLocator

from ghostball.engine.core.cache_folder import cache_folder
from ghostball.model import events, impact_laws
from ghostball.model.trajectory import polynomial

logger = logging.getLogger("ghostball.engine")

FLAGS = ("BOUNDSCHECK", "OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "CPU_NAME", "CPU_FEATURES")
"""Settings of numba that change the machine code."""

KEPT_CACHES = 12
"""Caches of other sources or flags that are kept, each of some 30 MB.

Enough for a few checkouts beside each other: each has one for its kernels, one for those that check
bounds, and small ones for copies of the engine that tests compile.
"""

UNUSED = 86_400.0
"""Time after its last use before which no cache is removed [s]: a day.

A process may still load from what it used lately. One that runs for longer has what it needs in
memory, compiles anew what else it comes to, and makes the folder again to keep it.
"""

_MARKER = "CACHEDIR.TAG"
_MARKED = b"""Signature: 8a477f597d28d172789f06886806bc55
# Compiled kernels of Ghostball, which removes this folder when it has not been used for long.
"""
"""The file by which a cache is known as ours, and by which backups leave it out.

It is that of the Cache Directory Tagging Specification (bford.info/cachedir).
"""

_PACKAGE = Path(__file__).resolve().parent.parent

FROM_MODEL = (events, impact_laws, polynomial)
"""Modules of the model that kernels take constants and functions from: these are in machine code.

The others aren't, so that who edits them needn't wait for the compiler.
"""


class KernelCache(FunctionCache):
    """What is kept of one kernel.

    numba is given the folder here, not by its setting, which is the whole process's: another thread
    that compiles a function of its own would write it into our cache.
    """

    def __init__(self, function: Callable[..., Any], directory: Path, kind: str) -> None:
        self._directory = directory
        locator = _Locator(function, directory / kind)
        places = {"_locator_classes": [locator]}
        self._impl_class: Any = type("_Kept", (CompileResultCacheImpl,), places)
        super().__init__(function)  # type: ignore[no-untyped-call]

    def save_overload(self, signature: Any, code: Any) -> None:
        """Keep the machine code for these types of arguments.

        No two processes do so at the same time. numba reads the kernel's index, picks the next free
        name, and writes index and machine code under it: of two that do so side by side, each for
        its own variant, one's index may be left with the other's code, and from then on that
        variant can't be loaded, nor compiled. Nor is the folder removed meanwhile; where it was
        removed before, it is made again.
        """
        with locked(self._directory):
            super().save_overload(signature, code)  # type: ignore[no-untyped-call]


class _Locator(_CacheLocator):
    """Says where one kernel is kept, and what its file must be for that to be fresh."""

    def __init__(self, function: Callable[..., Any], directory: Path) -> None:
        file = Path(inspect.getfile(function)).resolve()
        self._py_file = str(file)  # numba reads it for a warning
        self._line = str(function.__code__.co_firstlineno)
        # What lies in this package is in the name of the directory already.
        self._stamp = "" if file.is_relative_to(_PACKAGE) else _hash_of_folder(file.parent)
        below: str = self.get_suitable_cache_subpath(str(file))  # type: ignore[no-untyped-call]
        self._path = str(directory / below / self._stamp)

    def from_function(self, *_: object) -> _Locator:  # type: ignore[override]
        """Return this one, which was made for the function."""
        return self

    def get_cache_path(self) -> str:
        """Return the folder that keeps it."""
        return self._path

    def get_source_stamp(self) -> str:
        """Return a hash of the sources that the folder's name doesn't have."""
        return self._stamp

    def get_disambiguator(self) -> str:
        """Return what tells it from another of its name in its file."""
        return self._line


@cache
def cache_directory() -> Path | None:
    """Directory of this package's compiled kernels; made, and old ones removed, on first use.

    None where it can't be written: kernels are then compiled in each process anew, and a warning
    says so.
    """
    root = cache_folder("kernels")
    directory = root / cache_key()
    try:
        with locked(directory):
            tempfile.TemporaryFile(dir=directory).close()
        _prune(root)
    except OSError as error:
        logger.warning(
            "compiled kernels can't be kept in %s: %s. Every run will compile them again; set "
            "GHOSTBALL_CACHE_DIR to a directory that can be written",
            root,
            error.strerror or type(error).__name__,
        )
        return None
    return directory


@contextmanager
def locked(directory: Path) -> Iterator[None]:
    """Let nobody else write to a cache, nor remove one, and note that this one is used.

    Made where it isn't there, also when it was removed under a process that runs for long.
    """
    directory.parent.mkdir(parents=True, exist_ok=True)
    with _lock_of(directory.parent):
        directory.mkdir(exist_ok=True)
        (directory / _MARKER).write_bytes(_MARKED)
        os.utime(directory)
        yield


def _lock_of(root: Path) -> FileLock:
    return FileLock(root / "kernels.lock")


def cache_key() -> str:
    """Hash of all that decides the machine code: sources, versions, flags, the processor.

    And of where the sources lie, since numba keeps what it compiles by their paths: of two equal
    checkouts each compiles, and says so. The flags are in it because a warm numba cache ignores
    those of bounds checks and of the optimiser. The processor is in it because numba compiles anew
    for another one, without a word: where machines share a home, or a CI restores a cache.
    """
    flags = [getattr(numba.config, name) for name in FLAGS]
    versions = [numba.__version__, llvmlite.__version__, np.__version__]
    of_model = [Path(inspect.getfile(module)).resolve() for module in FROM_MODEL]
    sources = _hash_of([*_PACKAGE.rglob("*.py"), *of_model])
    parts = (str(_PACKAGE), sources, flags, versions, _processor())
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:20]


@cache
def _hash_of_folder(folder: Path) -> str:
    return _hash_of(folder.glob("*.py"))


def _hash_of(files: Iterable[Path]) -> str:
    """Return a hash of files' names and contents."""
    digest = hashlib.sha256()
    for path in sorted(files):
        digest.update(os.fsencode(path) + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()[:20]


def _processor() -> tuple[str, str]:
    """Return the processor's name and features, as the compiler calls them."""
    features = llvmlite.binding.get_host_cpu_features()
    return llvmlite.binding.get_host_cpu_name(), features.flatten()


def _prune(root: Path) -> None:
    """Remove the caches that are not among those used last, nor were used within a day.

    Only what we made: a folder that is named as a cache is, and that has our marker in it.
    """
    ours = [path for path in root.iterdir() if _is_ours(path)]
    ours.sort(key=_last_use, reverse=True)
    try:
        with _lock_of(root).acquire(timeout=0):
            for path in ours[KEPT_CACHES + 1 :]:
                # Looked at again, now that nobody can begin to use it.
                if _last_use(path) < time.time() - UNUSED:
                    _remove(path)
    except Timeout:
        return  # someone else removes them, or keeps something: there will be another time


def _is_ours(path: Path) -> bool:
    if not re.fullmatch("[0-9a-f]{20}", path.name) or path.is_symlink():
        return False
    try:
        return (path / _MARKER).read_bytes() == _MARKED
    except OSError:
        return False


def _last_use(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0


def _remove(cache: Path) -> None:
    """Remove a cache: first what says that it has something, and last what says that it is ours."""
    parts = sorted(cache.iterdir(), key=lambda path: (path.name == _MARKER, path.is_dir()))
    for path in parts:
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            with suppress(OSError):
                path.unlink()
    with suppress(OSError):
        cache.rmdir()
