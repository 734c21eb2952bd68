"""Compiles a kernel into a shared library; loaded only where that is done, with numba.

Numba compiles the kernel with all that it calls, LLVM makes an object file for the target, and the
system's linker makes the library of that. Where there is none, or it fails, the object file stays.
"""

from __future__ import annotations

import gc
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import llvmlite.binding as llvm
import numba
from numba.core import types
from numba.core.base import BaseContext
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_lock import global_compiler_lock
from numba.core.funcdesc import default_mangler
from numba.core.types.functions import BaseFunction

from ghostball.engine.library import generated, processor, table
from ghostball.engine.library.load import SYMBOL
from ghostball.engine.library.reached import (
    by_reference,
    is_inline,
    is_ours,
    kernel_in,
    names_in,
    reached_by,
)

OPTIONS: dict[str, Any] = {
    "error_model": "numpy",  # no raising: a division by zero gives inf, as the arithmetic says
    "fastmath": False,  # no fused multiply-add, no reordering: the same bits on every machine
    # No reference counts: kernels allocate nothing, and counting the arrays of each call took more
    # than half of the time.
    "_nrt": False,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}

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
    fits = _dispatcher(generated.fits, vars(generated))
    whole = generated.unpacking(_compilable(kernel), fits, kinds, result)
    options = {**OPTIONS, "pipeline_class": _EntryCompiler}
    compiled = numba.njit(**options)(whole)
    with _changed_numba():
        compiled.compile((types.int64,))
    made = compiled.overloads[(types.int64,)]
    with global_compiler_lock:
        whole_module = made.library._get_module_for_linking()
    module = llvm.parse_bitcode(whole_module.as_bitcode())
    module.link_in(llvm.parse_assembly(generated.reshape_module()))
    for each in (*module.functions, *module.global_variables):
        if not each.is_declaration:
            each.linkage = "internal"
    entry = module.get_function(made.fndesc.llvm_func_name)
    entry.linkage, entry.name = "external", SYMBOL
    wanted = [one.name for one in module.functions if one.is_declaration]
    unknown = [name for name in wanted if name.startswith(OF_OTHERS)]
    if unknown:
        raise TypeError(f"the kernel `{kernel.__name__}` calls {unknown}, which no library has")
    triple = processor.other_triple()
    if triple is not None:
        llvm.initialize_all_targets()
        llvm.initialize_all_asmprinters()
    machine = llvm.Target.from_triple(triple or llvm.get_default_triple()).create_target_machine(
        cpu=target, opt=3, reloc="pic", codemodel="default"
    )
    if triple is not None:  # numba wrote it for this machine; the same words mean the same there
        module.triple, module.data_layout = triple, str(machine.target_data)
    return bytes(machine.emit_object(module))


_COMPILABLE: dict[Any, Any] = {by_reference: generated.by_reference}
"""The kernels that numba knows: what one is compiled into is there for the next, too."""


def _compilable(kernel: FunctionType) -> Any:
    """Return a kernel as numba's, and with it all that it calls."""
    new = [one for one in reached_by(kernel).functions if one not in _COMPILABLE]
    spaces = {one: dict(one.__globals__) for one in new}
    _COMPILABLE.update({one: _dispatcher(one, spaces[one]) for one in new})
    for one in new:
        for name, value in names_in(one):
            below = kernel_in(value)
            if below is None:
                if is_ours(value):
                    spaces[one][name] = _Module(value)
                continue
            module, _, last = name.rpartition(".")
            space = vars(spaces[one][module]) if module else spaces[one]
            space[last] = _COMPILABLE[below]
    return _COMPILABLE[kernel]


class _Module(ModuleType):
    """A module with what another has; some of it is then replaced here, and not there."""

    def __init__(self, module: ModuleType) -> None:
        super().__init__(module.__name__)
        vars(self).update(vars(module))


def _dispatcher(kernel: Any, space: dict[str, Any]) -> Any:
    copy = FunctionType(kernel.__code__, space, kernel.__name__, kernel.__defaults__)
    copy.__module__, copy.__qualname__ = kernel.__module__, kernel.__qualname__
    options = {**OPTIONS, "forceinline": is_inline(kernel), "pipeline_class": _InnerCompiler}
    return _without_literals(numba.njit(**options)(copy))


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


@contextmanager
def _changed_numba() -> Iterator[None]:
    """Have all of numba name kernels shortly, and remember what operations give of which types.

    A name has all types in it: two thousand letters, which every call repeats, and nobody reads.
    What adding two numbers gives was looked for in all rules of numpy's at each sum of a kernel.
    """
    kept = BaseContext.mangler, BaseFunction.get_call_type
    of_types: Any = kept[1]

    def short(_: Any, name: str, kinds: Any, *, abi_tags: Any = (), uid: Any = None) -> str:
        number = _NAMES.setdefault((name, tuple(kinds), tuple(abi_tags)), len(_NAMES))
        named: str = default_mangler(f"{name}_{number}", (), uid=uid)  # type: ignore[no-untyped-call]
        return named

    def remembered(operation: Any, context: Any, args: Any, kws: Any) -> Any:
        if kws:
            return of_types(operation, context, args, kws)
        known = _SIGNATURES.setdefault(id(operation), (operation, {}))[1]
        if args not in known:
            known[args] = of_types(operation, context, args, kws)
        return known[args]

    changed: Any = BaseContext, BaseFunction
    changed[0].mangler, changed[1].get_call_type = short, remembered
    try:
        yield
    finally:
        changed[0].mangler, changed[1].get_call_type = kept


_NAMES: dict[Any, int] = {}
"""Numbers that stand for a name and its types."""

_SIGNATURES: dict[int, tuple[Any, dict[Any, Any]]] = {}
"""What an operation of numba's gives, by its `id`; itself as well, so that no other gets that."""


class _InnerCode(JITCodeLibrary):
    """Code of a kernel that only other kernels call: it becomes part of theirs.

    numba optimises each kernel with all that it calls, and makes machine code of it; so a kernel is
    done as often as there are kernels above it. That took two thirds of the time to compile. Here
    both are done once, for the entry; the bits are the same, and the code is faster by a few per
    cent, since the optimiser sees the whole. Nor is what it calls linked to it: the entry links
    every kernel once.
    """

    def _optimize_functions(self, module: Any) -> None:
        """Optimise each function by itself, as numba does, but prepare the optimiser once for all.

        Not at all would be slower: each is then optimised wherever it is inlined.
        """
        module.data_layout = self._codegen._data_layout
        passes, builder = self._codegen._function_pass_manager()  # type: ignore[no-untyped-call]
        for function in module.functions:
            if not function.is_declaration:
                passes.run(function, builder)

    def finalize(self) -> None:
        """Keep the kernel's own code, which others link."""
        self._finalized = True


class _EntryCode(JITCodeLibrary):
    """Code of the kernel that Python calls, with that of all kernels below it."""

    def finalize(self) -> None:
        """Link all kernels that are below it, each once.

        Callers come before what they call: LLVM leaves out what nobody has called so far.
        """
        found: dict[Any, None] = {}

        def visit(code: Any) -> None:
            for one in code._linking_libraries:
                if one not in found:
                    visit(one)
                    found[one] = None

        visit(self)
        self._linking_libraries = list(reversed(found))
        super().finalize()  # type: ignore[no-untyped-call]

    def _optimize_final_module(self) -> None:
        """Optimise it, as one whose kernels nobody else calls.

        Then what a kernel doesn't use of what it is passed isn't passed: of some 200 words, which a
        few named tuples of arrays are, all but a dozen, in half of the calls.
        """
        for function in self._final_module.functions:
            if function.linkage == llvm.Linkage.linkonce_odr:
                function.linkage = "internal"
        super()._optimize_final_module()  # type: ignore[no-untyped-call]

    def _finalize_final_module(self) -> None:
        """Leave the machine code to `object_code`."""
        self._finalized = True


class _EntryCompiler(Compiler):
    library: Any = _EntryCode

    def compile_extra(self, function: Callable[..., Any]) -> Any:
        """Compile, as numba does, but into a library of another kind, which isn't run here."""
        self.state.flags.no_compile = True
        self.state.library = self.library(self.state.targetctx.codegen(), function.__qualname__)
        made: Any = super().compile_extra(function)  # type: ignore[no-untyped-call]
        # By which numba knows it: a builtin function, another for each; nobody calls it.
        key = object().__sizeof__
        self.state.targetctx.insert_user_function(key, made.fndesc, [made.library])
        return made._replace(entry_point=key)


class _InnerCompiler(_EntryCompiler):
    library: Any = _InnerCode
