"""Find the library of a kernel: a shipped one, one in the cache, or a newly compiled one."""

from __future__ import annotations

import ctypes
import hashlib
import json
import logging
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import FunctionType
from typing import Any, NamedTuple

from ghostball.engine.library import cache as kept, processor, shipped, table
from ghostball.engine.library.reached import kernel_in, reached_by
from ghostball.model.cache_folder import CACHE_DIR_VARIABLE, note_use
from ghostball.model.errors import GhostballError

logger = logging.getLogger("ghostball.engine")

SYMBOL = "ghostball_kernel"
"""The name of the kernel's function in its library."""

_LOADED: list[Any] = []
"""Objects loaded by LLVM, which must exist as long as their code may be called."""


class NoCompilerError(GhostballError):
    """A kernel has to be compiled, but no compiler is installed."""


def find(function: FunctionType, kinds: table.Kind) -> Path | None:
    """Return the library of a kernel for some kinds of arguments, or None if there is none yet."""
    path = shipped.files().get(shipped.key_of(function, kinds))
    if path is not None:
        return path
    folder = kept.directory()
    return None if folder is None else _made_at(folder / name_of(function, kinds))


def _made_at(path: Path) -> Path | None:
    """Return the library, or its object file if no linker was found, or None if neither exists."""
    for one in (path, path.with_suffix(".o")):
        if one.exists():
            return one
    return None


def make(function: FunctionType, kinds: table.Kind, what: str) -> Path:
    """Compile a kernel, log a message, and return its library.

    The message is a warning, because a program without logging settings prints warnings on stderr.
    If several processes need the same kernel, one compiles it and the others wait.
    """
    folder = kept.directory()
    if folder is None:
        # Only this process loads from the folder. It stays, since Windows can't remove a library
        # that is in use.
        return _compiled(function, kinds, what, Path(tempfile.mkdtemp(prefix="ghostball-")))
    with kept.alone(folder / name_of(function, kinds)):
        path = _made_at(folder / name_of(function, kinds))
        if path is None:
            path = _compiled(function, kinds, what, folder)
            kept.prune(folder)
    return path


def _compiled(function: FunctionType, kinds: table.Kind, what: str, folder: Path) -> Path:
    check_compiler()
    logger.warning("compiling the engine's kernels (%s), once; it may take half a minute ...", what)
    path = folder / name_of(function, kinds)
    build([Order(function, kinds, path)])
    return _made_at(path) or path


def check_compiler() -> None:
    """Raise `NoCompilerError` without a compiler; call this before announcing a compilation."""
    if find_spec("numba") is None:
        raise NoCompilerError(
            "kernels must be compiled, but numba, the compiler, isn't installed. Run "
            "`pip install '.[compiler]'` in a clone of Ghostball"
        )


class Order(NamedTuple):
    """A library that has to be made."""

    function: FunctionType
    kinds: table.Kind
    path: Path


def build(orders: list[Order], finished: Callable[[int], None] = lambda _: None) -> None:
    """Compile kernels into libraries, all in one separate process.

    The reasons for a separate process: numba has one target per process, and a compilation takes a
    gigabyte or two of memory, which the end of the process releases. Kernels with much in common
    are compiled in half the time if one process compiles them.

    `finished`: called with the index of each order when its library is made.

    Raises `GhostballError` if a kernel can't be compiled, or there is no compiler.
    """
    check_compiler()
    told = [
        {
            "kernel": f"{one.function.__module__}:{one.function.__qualname__}",
            "kinds": one.kinds,
            "target": processor.target(),
            "out": str(one.path),
            "digest": _digest(one.function),
        }
        for one in orders
    ]
    settings = {
        "NUMBA_CPU_NAME": processor.target(),
        "NUMBA_CPU_FEATURES": "",
        # numba formats a message, with colours, for every failed attempt; nobody sees them.
        "NUMBA_DISABLE_ERROR_MESSAGE_HIGHLIGHTING": "1",
    }
    with tempfile.TemporaryFile("w+") as messages:
        process = subprocess.Popen(
            [sys.executable, "-c", _ORDERED],
            env={**os.environ, **settings},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=messages,
            text=True,
        )
        with process:
            assert process.stdin is not None
            assert process.stdout is not None
            try:
                json.dump({"path": sys.path, "orders": told}, process.stdin)
                process.stdin.close()
                for line in process.stdout:
                    place, _, why_not = line.strip().partition(" ")
                    if why_not:
                        _say_unlinked(why_not)
                    finished(int(place))
            finally:
                if sys.exc_info()[0] is not None:
                    process.kill()
        messages.seek(0)
        said = messages.read().strip()
        if process.returncode != 0:
            raise GhostballError(
                f"the kernels {sorted({one['kernel'] for one in told})} could not be compiled "
                f"(exit status {process.returncode}): {said}"
            )
        if said:
            _say_of_compiler(said)


@cache
def _say_of_compiler(said: str) -> None:
    """Log once the warnings of the process that compiles."""
    logger.warning("while kernels were compiled: %s", said)


@cache
def _say_unlinked(why_not: str) -> None:
    """Log once why a kernel wasn't linked; the reason is the same for all kernels."""
    logger.warning(
        "no library could be linked, so LLVM links the kernels in each process: %s", why_not
    )


_ORDERED = """
import json, sys
told = json.load(sys.stdin)
sys.path[:] = told["path"]
from ghostball.engine.library.build import build
from ghostball.engine.library.load import check_sources
for place, order in enumerate(told["orders"]):
    check_sources(order)
    print(place, build(order), flush=True)
"""


def check_sources(order: dict[str, Any]) -> None:
    """Refuse an order if its kernel has changed since the other process gave the order.

    The library's name is the hash of the old sources, so programs with the old sources would load a
    library made from the new sources.
    """
    function = kernel_in(table.named(order["kernel"]))
    if function is None or _digest(function) != order["digest"]:
        raise GhostballError(
            "the sources of the kernel changed after the program started. Start the program again"
        )


def name_of(function: FunctionType, kinds: table.Kind) -> str:
    """Return the name of a library made here, with a hash of everything it depends on."""
    whole = table.text_of([kinds, table.kind_of_result(function)])
    parts = (_digest(function), whole, processor.target(), shipped.flags())
    digest = hashlib.sha256(repr((parts, _compiler(), processor.system())).encode())
    return f"{function.__name__.strip('_')}-{digest.hexdigest()[:20]}.so"


@cache
def _digest(function: FunctionType) -> str:
    return reached_by(function).digest


_COMPILING = ("build.py", "generated.py", "numba_doors.py", "plain_numba.py")
"""The modules that call the compiler."""


@cache
def _compiler() -> str:
    """Return the compiler as text: versions of numba and LLVM, and a hash of `_COMPILING`."""
    from importlib.metadata import PackageNotFoundError, version  # noqa: PLC0415 - slow to import

    try:
        compilers = f"{version('numba')} {version('llvmlite')}"
    except PackageNotFoundError:
        compilers = ""
    beside = Path(__file__).parent
    own = [(beside / name).read_bytes() for name in _COMPILING]
    return f"{compilers} {table.VERSION} {hashlib.sha256(b''.join(own)).hexdigest()}"


def entry(function: FunctionType, kinds: table.Kind, what: str) -> Any:
    """Return a kernel from its library, after compiling it if necessary.

    If the system can't load a shipped library, all shipped libraries are set aside.

    Raises `GhostballError` if a library made here can't be loaded, or can't be made.
    """
    path = find(function, kinds) or make(function, kinds, what)
    try:
        return entry_of(path)
    except OSError as error:
        if path not in shipped.files().values():
            raise GhostballError(
                f"the system can't load the compiled library: {error}. Remove it, or set "
                f"{CACHE_DIR_VARIABLE} to another folder"
            ) from error
        shipped.set_aside(str(error))
    return entry(function, kinds, what)


def entry_of(path: Path) -> Any:
    """Load a library, and return its kernel: a function whose arguments are addresses."""
    if path.suffix == ".o":
        address = _load_object(path)
        made = ctypes.CFUNCTYPE(ctypes.c_int32, *[ctypes.c_void_p] * 3)
        return made(address)
    note_use(path)
    function = getattr(ctypes.CDLL(str(path)), SYMBOL)
    function.restype = ctypes.c_int32
    return function


def _load_object(path: Path) -> int:
    """Link an object file into this process, if no linker could make a library from it."""
    import llvmlite.binding as llvm  # noqa: PLC0415 - where there is no other way

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine()
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(str(path))
    engine.finalize_object()
    _LOADED.append(engine)
    return int(engine.get_function_address(SYMBOL))
