"""Compiles a kernel into a shared library; loaded only where that is done, with numba.

Numba compiles the kernel with all that it calls, LLVM makes an object file for the target, and the
system's linker makes the library of that. Where there is none, or it fails, the object file stays.
"""

from __future__ import annotations

import gc
import logging
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import llvmlite.binding as llvm

from ghostball.engine.library import generated, processor, table
from ghostball.engine.library.load import SYMBOL
from ghostball.engine.library.plain_numba import Plain, for_machine, pass_builder
from ghostball.engine.library.reached import (
    by_reference,
    is_inline,
    is_ours,
    kernel_in,
    names_in,
    reached_by,
)

logger = logging.getLogger("ghostball.engine")

OF_OTHERS = ("numba_", "NRT_", "Py", "_Py", "_ZN")
"""How names begin of functions of numba or of Python: none of these is there when it is called."""

LINKERS = ("cc", "clang", "gcc")

LINKED_WITH = {
    # No library is needed: what is left to find is a few functions of C's that every process has.
    "linux": ["-s", "-nostdlib", "-Wl,--gc-sections,--build-id=none"],
    "darwin": ["-Wl,-dead_strip", "-Wl,-x"],
    "win32": ["-fuse-ld=lld", f"-Wl,-export:{SYMBOL}"],
}
"""What the linker is told besides, on each system."""


def build(order: dict[str, Any]) -> str:
    """Compile what `load.build` orders, and put the library, or the object file, in its place.

    Returns why it isn't a library, in one line, or nothing.
    """
    gc.disable()  # the compiler makes millions of objects and keeps them
    kernel = kernel_in(table.named(order["kernel"]))
    assert kernel is not None
    code = _in_one_piece(object_code, kernel, order["kinds"], order["result"], order["target"])
    place = Path(order["out"])
    with tempfile.TemporaryDirectory(dir=place.parent) as folder:
        made = Path(folder, "kernel.o")
        made.write_bytes(code)
        linked = Path(folder, "kernel.so")
        why_not = _link(made, linked)
        if not why_not:
            made = linked
        made.replace(place.with_suffix(made.suffix))
    return why_not


def _link(code: Path, library: Path) -> str:
    """Make a library of an object file; return why there is none, in one line, or nothing."""
    linker = os.environ.get("CC") or next(filter(shutil.which, LINKERS), None)
    if linker is None:
        return f"no C compiler was found, of {', '.join(LINKERS)}; CC may name one"
    more = LINKED_WITH.get(sys.platform, [])
    command = [*shlex.split(linker), "-shared", *more, "-o", str(library), str(code)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        return f"`{linker}` can't be run: {error.strerror}"
    if done.returncode == 0:
        return ""
    said = " ".join(done.stderr.split()) or f"exit status {done.returncode}"
    return f"`{linker}` failed: {said}"


def _in_one_piece(function: Callable[..., Any], *arguments: Any) -> Any:
    """Return `function(*arguments)`, called from a frame of more than a megabyte.

    CPython keeps a thread's frames in pieces of 16 kB, and asks the system for the next one, or
    gives it back, whenever a call crosses an end. Some of numba's longest loops happened to call
    across one: 420 000 times for one variant, a third of the time to compile. A frame that no such
    piece can hold gets one of 2 MB, and what it calls has the rest.
    """
    return function(*arguments)


_in_one_piece.__code__ = _in_one_piece.__code__.replace(co_stacksize=140_000)  # words


def object_code(
    kernel: FunctionType, kinds: list[table.Kind], result: table.Kind, target: str
) -> bytes:
    """Return the object file of a kernel for some kinds of arguments."""
    triple = processor.other_triple()
    if triple is None:
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
    else:
        llvm.initialize_all_targets()
        llvm.initialize_all_asmprinters()
    machine = llvm.Target.from_triple(triple or llvm.get_default_triple()).create_target_machine(
        cpu=target, opt=3, reloc="pic", codemodel="default"
    )
    module, name = _module(kernel, kinds, result, machine)
    module.link_in(for_machine(generated.RESHAPE, machine))
    made = [one for one in (*module.functions, *module.global_variables) if not one.is_declaration]
    for number, one in enumerate(made):
        # What a function that nobody else calls doesn't use of what it is passed isn't passed: of
        # some 200 words, which a few named tuples of arrays are, all but a dozen, in half of the
        # calls. Names have all types in them: two thousand letters, which nobody reads.
        is_entry = one.name == name
        one.linkage = "external" if is_entry else "internal"
        one.name = SYMBOL if is_entry else f"part_{number}"
    builder = pass_builder(machine)
    passes = builder.getModulePassManager()
    passes.add_global_dead_code_eliminate_pass()  # with NUMBA_OPT=0, too, what nobody calls goes
    passes.run(module, builder)
    wanted = [one.name for one in module.functions if one.is_declaration]
    unknown = [name for name in wanted if name.startswith(OF_OTHERS)]
    if unknown:
        raise TypeError(f"the kernel `{kernel.__name__}` calls {unknown}, which no library has")
    return bytes(machine.emit_object(module))


def _module(
    kernel: FunctionType, kinds: list[table.Kind], result: table.Kind, machine: Any
) -> tuple[Any, str]:
    """Return the LLVM module of a kernel that takes a table, and the kernel's name in it.

    Where a door of numba's doesn't open, this process compiles without them from then on.

    Raises `TypeError` as `reached_by`: before numba is asked, so that a mistake in a kernel isn't
    taken for a change in numba.
    """
    functions = reached_by(kernel).functions
    chosen = way()
    try:
        fits: Any = generated.fits
        fits = chosen.dispatcher(_copy(fits, vars(generated)), forceinline=True)
        whole = generated.unpacking(_compilable(kernel, functions, chosen), fits, kinds, result)
        return chosen.module(chosen.dispatcher(whole), machine)
    except (AttributeError, TypeError) as error:
        if type(chosen) is Plain:
            raise
        _compile_plainly(error)
    return _module(kernel, kinds, result, machine)


def way() -> Plain:
    """Return how this process compiles."""
    if not _WAY:
        try:
            from ghostball.engine.library.numba_doors import Doors  # noqa: PLC0415 - may fail
        except (ImportError, AttributeError, TypeError) as error:
            _compile_plainly(error)
        else:
            _WAY.append(Doors())
    return _WAY[0]


def _compile_plainly(error: Exception) -> None:
    _WAY[:] = [Plain()]
    logger.warning(
        "numba %s differs from what the engine knows (%s: %s); kernels take longer to compile",
        version("numba"),
        type(error).__name__,
        error,
    )


_WAY: list[Plain] = []
"""How this process compiles, once it has compiled."""


def _compilable(kernel: FunctionType, functions: tuple[FunctionType, ...], chosen: Plain) -> Any:
    """Return a kernel as numba's dispatcher, and make dispatchers of the functions it reaches.

    `functions`: the kernel and all kernels below it.
    """
    known = chosen.kernels
    known.setdefault(by_reference, generated.by_reference)
    new = [one for one in functions if one not in known]
    spaces = {one: dict(one.__globals__) for one in new}
    for one in new:
        known[one] = chosen.dispatcher(_copy(one, spaces[one]), forceinline=is_inline(one))
    for one in new:
        for name, value in names_in(one):
            below = kernel_in(value)
            if below is None:
                if is_ours(value):
                    spaces[one][name] = _Module(value)
                continue
            module, _, last = name.rpartition(".")
            space = vars(spaces[one][module]) if module else spaces[one]
            space[last] = known[below]
    return known[kernel]


class _Module(ModuleType):
    """A module with what another has; some of it is then replaced here, and not there."""

    def __init__(self, module: ModuleType) -> None:
        super().__init__(module.__name__)
        vars(self).update(vars(module))


def _copy(function: FunctionType, space: dict[str, Any]) -> FunctionType:
    """Return a function that finds its names in another space."""
    copy = FunctionType(function.__code__, space, function.__name__, function.__defaults__)
    copy.__module__, copy.__qualname__ = function.__module__, function.__qualname__
    return copy
