"""Compile a kernel into a shared library, with numba; only a process that compiles imports this.

numba compiles the kernel with everything that it calls, LLVM makes an object file for the target,
and the linker of the system makes the library. Without a linker, or if linking fails, the object
file is kept.
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
"""Prefixes of functions of numba and of Python, which don't exist where a library is called."""

LINKERS = ("cc", "clang", "gcc")

LINKED_WITH = {
    # No library is needed: the code calls only a few C functions, which every process has.
    "linux": ["-s", "-nostdlib", "-Wl,--gc-sections,--build-id=none"],
    "darwin": ["-Wl,-dead_strip", "-Wl,-x"],
    "win32": ["-fuse-ld=lld", f"-Wl,-export:{SYMBOL}"],
}
"""Further arguments of the linker on each system."""


def build(order: dict[str, Any]) -> str:
    """Compile the kernel of an order of `load.build`; store the library, or the object file.

    Return why it isn't a library, in one line, or "".
    """
    gc.disable()  # the compiler makes millions of objects and keeps them
    kernel = kernel_in(table.named(order["kernel"]))
    assert kernel is not None
    code = _in_one_piece(object_code, kernel, order["kinds"], order["target"])
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
    """Link an object file into a library; return why that failed, in one line, or ""."""
    linker = os.environ.get("CC") or next(filter(shutil.which, LINKERS), None)
    if linker is None:
        return f"no C compiler found (tried {', '.join(LINKERS)}). Set CC to a compiler"
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

    CPython stores the frames of a thread in chunks of 16 kB. When a call crosses the end of a
    chunk, CPython gets another chunk from the system, or returns a chunk to the system. Some of
    numba's longest loops had such calls: 420 000 for one variant, a third of the time to compile. A
    frame that is too large for a chunk gets a chunk of 2 MB; the functions that it calls use the
    rest.
    """
    return function(*arguments)


_in_one_piece.__code__ = _in_one_piece.__code__.replace(co_stacksize=140_000)  # words


def object_code(kernel: FunctionType, kinds: list[table.Kind], target: str) -> bytes:
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
    module, name = _module(kernel, kinds, machine)
    module.link_in(for_machine(generated.RESHAPE, machine))
    made = [one for one in (*module.functions, *module.global_variables) if not one.is_declaration]
    for number, one in enumerate(made):
        # LLVM removes unused arguments of internal functions. A few named tuples of arrays are
        # about 200 words; half of the calls need only a dozen. The names are short, because numba's
        # names contain all types: two thousand letters.
        is_entry = one.name == name
        one.linkage = "external" if is_entry else "internal"
        one.name = SYMBOL if is_entry else f"part_{number}"
    builder = pass_builder(machine)
    passes = builder.getModulePassManager()
    passes.add_global_dead_code_eliminate_pass()  # also with NUMBA_OPT=0
    passes.run(module, builder)
    wanted = [one.name for one in module.functions if one.is_declaration]
    unknown = [name for name in wanted if name.startswith(OF_OTHERS)]
    if unknown:
        raise TypeError(f"the kernel `{kernel.__name__}` calls {unknown}, which no library has")
    return bytes(machine.emit_object(module))


def _module(kernel: FunctionType, kinds: list[table.Kind], machine: Any) -> tuple[Any, str]:
    """Return the LLVM module of a kernel that takes a table, and the kernel's name in it.

    If a private part of numba has changed (`numba_doors`), this process compiles without private
    parts from then on.

    Raises `TypeError` as `reached_by`, which runs before numba, so that a mistake in a kernel isn't
    taken for a change in numba.
    """
    functions = reached_by(kernel).functions
    chosen = way()
    try:
        fits: Any = generated.fits
        fits = chosen.dispatcher(_copy(fits, vars(generated)), forceinline=True)
        result = table.kind_of_result(kernel)
        whole = generated.unpacking(_compilable(kernel, functions, chosen), fits, kinds, result)
        return chosen.module(chosen.dispatcher(whole), machine)
    except (AttributeError, TypeError) as error:
        if type(chosen) is Plain:
            raise
        _compile_plainly(error)
    return _module(kernel, kinds, machine)


def way() -> Plain:
    """Return the compiler of this process: `Doors`, or `Plain` if numba has changed."""
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
"""The compiler of this process, after its first use."""


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
    """A copy of a module; replacing an attribute of the copy doesn't change the module."""

    def __init__(self, module: ModuleType) -> None:
        super().__init__(module.__name__)
        vars(self).update(vars(module))


def _copy(function: FunctionType, space: dict[str, Any]) -> FunctionType:
    """Return a copy of a function that looks up global names in `space`."""
    copy = FunctionType(function.__code__, space, function.__name__, function.__defaults__)
    copy.__module__, copy.__qualname__ = function.__module__, function.__qualname__
    return copy
