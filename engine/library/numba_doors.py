"""The private parts of numba that only make compiling faster.

Each part is called a door. If a release of numba has changed a door, `build` uses `plain_numba`
instead: the kernels are bit-identical, compiling takes longer, and a warning says so. A door is
kept while it saves at least 15 % of the time to compile. `python -m benchmarks doors` measures the
time to compile the lean kernel with both doors, without `by_common_types`, and without both.

- `_Code` with `_Compiler` uses `CodeLibrary` (its six abstract methods and `_finalized`), and
  `compile_extra`, `state.library`, `flags.no_compile`, `insert_user_function` and `entry_point` of
  the compiler. It fails with ImportError or AttributeError if a name is gone, and with TypeError if
  another method is abstract or has other arguments.
- `by_common_types` sets `get_call_template` of a dispatcher. It fails with AttributeError if the
  name is gone. If numba no longer calls this method, a test finds a kernel that is compiled twice.

The slow test `tests/engine/library/test_numba_versions.py` compiles with both doors, with the
lowest and the highest version of numba that pyproject.toml allows. Run this test before you change
one of the two versions.

Four more doors were tried and left out, because each saves too little: short names of kernels
(`BaseContext.mangler`), a cache for the types of operations (`BaseFunction.get_call_type`), one
optimiser for all functions (`_optimize_functions`), no machine code by numba
(`_finalize_final_module`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba
from numba import types
from numba.core.codegen import CodeLibrary

from ghostball.engine.library.plain_numba import (
    OPTIONS,
    Passes,
    Plain,
    for_machine,
    name_of_entry,
    pass_builder,
)


class Doors(Plain):
    """The compiler that uses both doors."""

    def dispatcher(self, function: Callable[..., Any], **options: Any) -> Any:
        """Return numba's dispatcher of a function; it is compiled with a kernel that calls it."""
        made = numba.njit(**OPTIONS, **options, pipeline_class=_Compiler)(function)
        return by_common_types(made)

    def module(self, dispatcher: Any, machine: Any) -> tuple[Any, str]:
        """Compile a function of one integer; return its module with each callee once, and its name.

        numba optimises each kernel together with everything that it calls, and makes machine code
        of both. So each kernel is compiled as often as there are kernels above it. Here `build`
        does both once. The code is a few per cent faster, because the optimiser sees all of it.
        """
        dispatcher.compile(self.signature)
        codes = _linked_order(dispatcher.overloads[self.signature].library)
        first, *others = (one for code in codes for one in _modules(code, machine))
        whole, name = first.clone(), name_of_entry(first)
        for one in others:
            whole.link_in(one, preserve=True)
        return whole, name


class _Code(CodeLibrary):
    """The code of one kernel from numba, not optimised, and not linked with its callees."""

    def __init__(self, codegen: Any, name: str) -> None:
        super().__init__(codegen, name)
        self.texts: list[str] = []
        self.made: list[Any] = []
        self.below: list[Any] = []

    def add_ir_module(self, ir_module: Any) -> None:
        """Store a module of the kernel."""
        self.texts.append(str(ir_module))

    def add_linking_library(self, library: Any) -> None:
        """Store a library that the kernel calls."""
        self.below.append(library)

    def finalize(self) -> None:
        """Do nothing: `Doors.module` of the entry does the work once for all kernels."""
        self._finalized = True

    def get_llvm_str(self) -> str:
        """Return the kernel's own code."""
        return "\n".join(self.texts)

    def get_function(self, name: str) -> Any:
        """Raise, because no code calls this method."""
        raise NotImplementedError

    def get_asm_str(self) -> str:
        """Raise, because no code calls this method."""
        raise NotImplementedError


def _linked_order(entry: Any) -> list[Any]:
    """Return an entry's code and all below it, callers before what they call."""
    found: dict[Any, None] = {}

    def visit(code: Any) -> None:
        for one in getattr(code, "below", ()):  # libraries of numba contain their callees
            if one not in found:
                visit(one)
                found[one] = None

    visit(entry)
    return [entry, *reversed(found)]


def _modules(code: Any, machine: Any) -> list[Any]:
    """Return a kernel's code with each function optimised alone, or code of numba's own library.

    Without this step, each function would be optimised again wherever it is inlined.
    """
    if not isinstance(code, _Code):
        return [for_machine(code.get_llvm_str(), machine)]
    if not code.made:
        code.made = [for_machine(text, machine) for text in code.texts]
        code.texts = []
        builder = pass_builder(machine)
        passes = builder.getFunctionPassManager()
        for module in code.made:
            for function in module.functions:
                if not function.is_declaration:
                    passes.run(function, builder)
    return code.made


class _Compiler(Passes):
    def compile_extra(self, function: Callable[..., Any]) -> Any:
        """Compile as numba does, but into a `_Code`, which this process doesn't run."""
        self.state.flags.no_compile = True
        self.state.library = _Code(self.state.targetctx.codegen(), function.__qualname__)
        made: Any = super().compile_extra(function)  # type: ignore[no-untyped-call]
        # numba's key for this code: a new builtin function for each kernel, which is never called.
        key = object().__sizeof__
        self.state.targetctx.insert_user_function(key, made.fndesc, [made.library])
        return made._replace(entry_point=key)


def by_common_types(dispatcher: Any) -> Any:
    """Treat a caller's constant, or an integer of half a word, like any other argument.

    Otherwise numba would compile a kernel, and everything that it calls, again for each constant
    that a caller passes, and again if the index of a ball comes from an array instead of a loop.
    """
    resolve = dispatcher.get_call_template
    dispatcher.get_call_template = lambda args, kws: resolve(
        tuple(_common(kind) for kind in args),
        {name: _common(kind) for name, kind in kws.items()},
    )
    return dispatcher


def _common(kind: Any) -> Any:
    kind = types.unliteral(kind)  # type: ignore[no-untyped-call]
    return types.int64 if kind in (types.int8, types.int16, types.int32) else kind
