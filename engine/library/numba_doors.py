"""The private parts of numba that the engine compiles with, to compile sooner: in this file alone.

Each part is called a door. If a release of numba has changed one, `build` compiles by `plain_numba`
instead: kernels come out the same, bit for bit, but later, and a warning says so. A door is kept
while it saves at least 15 % of the time to compile. `python -m benchmarks doors` measures the time
to compile the lean kernel with both doors, without `by_common_types`, and without both.

- `_Code` with `_Compiler`. Uses `CodeLibrary` (its six abstract methods and `_finalized`), and of
  the compiler `compile_extra`, `state.library`, `flags.no_compile`, `insert_user_function` and the
  result's `entry_point`. Fails with ImportError or AttributeError where a name is gone, with
  TypeError where another method is abstract or takes other arguments.
- `by_common_types`. Uses `get_call_template`, set on a dispatcher. Fails with AttributeError where
  the name is gone; where numba no longer calls it, a test sees a kernel that is compiled twice.

The slow test of numba's versions (`tests/engine/library/test_numba_versions.py`) compiles by both
doors with the lowest numba and the newest that pyproject.toml allows: run that test before you
change one of the two versions.

These were tried and left out, since each saves too little: short names of kernels
(`BaseContext.mangler`), a memory of what operations give (`BaseFunction.get_call_type`), one
optimiser for all functions (`_optimize_functions`), no machine code by numba
(`_finalize_final_module`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba
from numba import types
from numba.core.codegen import CodeLibrary
from numba.core.compiler import Compiler

from ghostball.engine.library.plain_numba import (
    OPTIONS,
    Plain,
    for_machine,
    name_of_entry,
    pass_builder,
)


class Doors(Plain):
    """Compiles by both doors."""

    def dispatcher(self, function: Callable[..., Any], **options: Any) -> Any:
        """Return a function as numba's, which compiles it when a kernel that calls it is."""
        made = numba.njit(**OPTIONS, **options, pipeline_class=_Compiler)(function)
        return by_common_types(made)

    def module(self, dispatcher: Any, machine: Any) -> tuple[Any, str]:
        """Compile a function of one integer; return its module, all in it once, and its name.

        numba optimises each kernel with all that it calls, and makes machine code of it; so a
        kernel is done as often as there are kernels above it. Here both are done once, by `build`;
        the code is faster by a few per cent, since the optimiser sees the whole.
        """
        dispatcher.compile(self.signature)
        codes = _linked_order(dispatcher.overloads[self.signature].library)
        first, *others = (one for code in codes for one in _modules(code, machine))
        whole, name = first.clone(), name_of_entry(first)
        for one in others:
            whole.link_in(one, preserve=True)
        return whole, name


class _Code(CodeLibrary):
    """The code of one kernel as numba wrote it, neither linked with what it calls nor optimised."""

    def __init__(self, codegen: Any, name: str) -> None:
        super().__init__(codegen, name)
        self.texts: list[str] = []
        self.made: list[Any] = []
        self.below: list[Any] = []

    def add_ir_module(self, ir_module: Any) -> None:
        """Keep a module of the kernel's."""
        self.texts.append(str(ir_module))

    def add_linking_library(self, library: Any) -> None:
        """Keep what the kernel calls."""
        self.below.append(library)

    def finalize(self) -> None:
        """Do nothing: the entry's `Doors.module` does all, once."""
        self._finalized = True

    def get_llvm_str(self) -> str:
        """Return the kernel's own code."""
        return "\n".join(self.texts)

    def get_function(self, name: str) -> Any:
        """Nobody asks."""
        raise NotImplementedError

    def get_asm_str(self) -> str:
        """Nobody asks."""
        raise NotImplementedError


def _linked_order(entry: Any) -> list[Any]:
    """Return an entry's code and all below it, callers before what they call."""
    found: dict[Any, None] = {}

    def visit(code: Any) -> None:
        for one in getattr(code, "below", ()):  # numba's own have theirs inside
            if one not in found:
                visit(one)
                found[one] = None

    visit(entry)
    return [entry, *reversed(found)]


def _modules(code: Any, machine: Any) -> list[Any]:
    """Return a kernel's code, each function optimised by itself, or code that numba itself made.

    Not at all would be slower: each is then optimised wherever it is inlined.
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


class _Compiler(Compiler):
    def compile_extra(self, function: Callable[..., Any]) -> Any:
        """Compile, as numba does, but into a `_Code`, which isn't run here."""
        self.state.flags.no_compile = True
        self.state.library = _Code(self.state.targetctx.codegen(), function.__qualname__)
        made: Any = super().compile_extra(function)  # type: ignore[no-untyped-call]
        # By which numba knows it: a builtin function, another for each; nobody calls it.
        key = object().__sizeof__
        self.state.targetctx.insert_user_function(key, made.fndesc, [made.library])
        return made._replace(entry_point=key)


def by_common_types(dispatcher: Any) -> Any:
    """Let a caller's constant, or an integer of half a word, be an argument like any other.

    numba would compile a kernel anew for each constant that a caller passes, and all that it calls;
    and again where the number of a ball comes from an array and not from a loop.
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
