"""Compile with the public parts of numba: options of `njit`, a function's LLVM code, and LLVM.

Three parts are undocumented and can't be replaced: the options `_nrt` and `no_*_wrapper`, without
which a kernel calls functions that exist only with numba, and `populate_array`, which makes an
array from an address. If one of them is gone, compiling fails with TypeError or ImportError. The
same holds for the models of types in `generated`, which numba documents.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import llvmlite.binding as llvm
import numba
from llvmlite import ir
from numba import types
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


class Plain:
    """The compiler without doors; it compiles a kernel as often as there are kernels above it."""

    signature = (types.int64,)

    def __init__(self) -> None:
        self.kernels: dict[Any, Any] = {}  # dispatchers, shared by all kernels that are compiled

    def dispatcher(self, function: Callable[..., Any], **options: Any) -> Any:
        """Return numba's dispatcher of a function; it is compiled with a kernel that calls it."""
        return numba.njit(**OPTIONS, **options)(function)

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
