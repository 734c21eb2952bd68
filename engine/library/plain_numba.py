"""Compile with the public parts of numba: options of `njit`, a function's LLVM code, and LLVM.

Four parts are undocumented and can't be replaced: the options `_nrt` and `no_*_wrapper`, without
which a kernel calls functions that exist only with numba; `populate_array`, which makes an array
from an address; and `_definitions` of numba's code, which the pass below changes. If one of them is
gone, compiling fails with AttributeError, TypeError or ImportError. The same holds for the models
of types in `generated`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import llvmlite.binding as llvm
import numba
from llvmlite import ir
from numba import types
from numba.core import ir as code
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.ir_utils import get_definition, guard
from numba.core.untyped_passes import InlineClosureLikes
from numba.np.arrayobj import populate_array

OPTIONS: dict[str, Any] = {
    "error_model": "numpy",  # no exceptions: a division by zero gives inf
    "fastmath": False,  # no fused multiply-add, no reordering: the same bits on every machine
    # No reference counts: kernels allocate nothing, and counting the arrays of each call took more
    # than half of the time.
    "_nrt": False,
    # Both wrappers call functions that exist only in a process that runs Python.
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}


@register_pass(mutates_CFG=False, analysis_only=False)  # type: ignore[no-untyped-call]
class _FieldsWithoutValue(FunctionPass):
    """Replace each field of an argument by None if its type says that it is None.

    numba leaves out the code after `x is not None` if x is an argument or a constant that is None,
    but not if x is a field of a named tuple. The lean kernel has such fields: see
    `core.state.World`.
    """

    _name = "fields_without_value"

    def __init__(self) -> None:
        super().__init__()  # type: ignore[no-untyped-call]

    def run_pass(self, state: Any) -> bool:
        """Change the function that numba compiles; return whether there was such a field."""
        changed = False
        for block in state.func_ir.blocks.values():
            for line in block.find_insts(code.Assign):
                field = line.value
                if isinstance(field, code.Expr) and _kind(state, field) == types.none:
                    line.value = code.Const(None, line.loc)  # type: ignore[no-untyped-call]
                    found = state.func_ir._definitions[line.target.name]
                    found[found.index(field)] = line.value
                    changed = True
        return changed


def _kind(state: Any, value: Any) -> Any:
    """Return the type of an argument or of its field, or of a field of the field; else None."""
    if isinstance(value, code.Var):
        value = guard(get_definition, state.func_ir, value)  # type: ignore[no-untyped-call]
    if isinstance(value, code.Arg):
        return state.args[value.index]
    if isinstance(value, code.Expr) and value.op == "getattr":
        whole = _kind(state, value.value)
        if isinstance(whole, types.NamedTuple | types.NamedUniTuple) and value.attr in whole.fields:
            return whole.types[whole.fields.index(value.attr)]
    return None


class Passes(CompilerBase):
    """numba's compiler, with one more pass."""

    def define_pipelines(self) -> list[Any]:
        """Return numba's passes, with `_FieldsWithoutValue` before branches are left out."""
        builder: Any = DefaultPassBuilder
        passes = builder.define_nopython_pipeline(self.state)
        passes.add_pass_after(_FieldsWithoutValue, InlineClosureLikes)
        passes.finalize()
        return [passes]


class Plain:
    """The compiler without doors; it compiles a kernel as often as there are kernels above it."""

    signature = (types.int64,)

    def __init__(self) -> None:
        self.kernels: dict[Any, Any] = {}  # dispatchers, shared by all kernels that are compiled

    def dispatcher(self, function: Callable[..., Any], **options: Any) -> Any:
        """Return numba's dispatcher of a function; it is compiled with a kernel that calls it."""
        return numba.njit(**OPTIONS, **options, pipeline_class=Passes)(function)

    def module(self, dispatcher: Any, machine: Any) -> tuple[Any, str]:
        """Compile a function of one integer; return its module with all callees, and its name."""
        dispatcher.compile(self.signature)
        module = for_machine(dispatcher.inspect_llvm(self.signature), machine)
        return module, name_of_entry(module)


def name_of_entry(module: Any) -> str:
    """Return the name of the only function that a module exports."""
    (name,) = (
        one.name
        for one in module.functions
        if not one.is_declaration and one.linkage == llvm.Linkage.external
    )
    return str(name)


def for_machine(text: str, machine: Any) -> Any:
    """Return LLVM code as a module for a machine; the code is the same for all machines."""
    module = llvm.parse_assembly(text)
    module.triple, module.data_layout = machine.triple, str(machine.target_data)
    return module


def pass_builder(machine: Any) -> Any:
    """Return a builder of LLVM's optimisers, with numba's settings."""
    config: Any = numba.config
    options = llvm.create_pipeline_tuning_options()
    options.speed_level = int(config.OPT)
    options.slp_vectorization = bool(config.SLP_VECTORIZE)
    options.loop_vectorization = bool(config.LOOP_VECTORIZE)
    return llvm.create_pass_builder(machine, options)


def array_in_one_piece(context: Any, builder: Any, kind: Any, address: Any, lengths: Any) -> Any:
    """Return numba's contiguous array for memory at an address, which the array doesn't own."""
    made = context.make_array(kind)(context, builder)
    size = ir.IntType(64)(context.get_abi_sizeof(context.get_data_type(kind.dtype)))
    strides: list[Any] = []
    step: Any = size
    for length in reversed(lengths):
        strides.insert(0, step)
        step = builder.mul(step, length)
    data = builder.inttoptr(address, made.data.type)
    populate: Any = populate_array
    populate(made, data, lengths, strides, size, meminfo=None)
    return made._getvalue()
