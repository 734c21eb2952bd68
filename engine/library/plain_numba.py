"""Numba as anyone uses it: options of `njit`, a function's LLVM code, and LLVM's own optimiser.

Three things here numba doesn't document, and nothing replaces them, so that compiling fails with
TypeError or ImportError where they are gone: the options `_nrt` and `no_*_wrapper`, without which a
kernel calls functions that only a process with numba has, and `populate_array`, by which an array
is made of an address. So do the models of types in `generated`, which numba documents.
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
    "error_model": "numpy",  # no raising: a division by zero gives inf, as the arithmetic says
    "fastmath": False,  # no fused multiply-add, no reordering: the same bits on every machine
    # No reference counts: kernels allocate nothing, and counting the arrays of each call took more
    # than half of the time.
    "_nrt": False,
    # Both wrappers call what only a process that runs Python has.
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}


class Plain:
    """Compiles by what numba documents; each kernel as often as there are kernels above it."""

    signature = (types.int64,)

    def __init__(self) -> None:
        self.kernels: dict[Any, Any] = {}  # what one is compiled into is there for the next, too

    def dispatcher(self, function: Callable[..., Any], **options: Any) -> Any:
        """Return a function as numba's, which compiles it when a kernel that calls it is."""
        return numba.njit(**OPTIONS, **options)(function)

    def module(self, dispatcher: Any, machine: Any) -> tuple[Any, str]:
        """Compile a function of one integer; return its module, with all it calls, and its name."""
        dispatcher.compile(self.signature)
        module = for_machine(dispatcher.inspect_llvm(self.signature), machine)
        return module, name_of_entry(module)


def name_of_entry(module: Any) -> str:
    """Return the name of the one function that a module has for others."""
    (name,) = (
        one.name
        for one in module.functions
        if not one.is_declaration and one.linkage == llvm.Linkage.external
    )
    return str(name)


def for_machine(text: str, machine: Any) -> Any:
    """Return LLVM's code as a module for a machine: the same words mean the same there."""
    module = llvm.parse_assembly(text)
    module.triple, module.data_layout = machine.triple, str(machine.target_data)
    return module


def pass_builder(machine: Any) -> Any:
    """Return what makes LLVM's optimisers, with numba's settings for them."""
    config: Any = numba.config
    options = llvm.create_pipeline_tuning_options()
    options.speed_level = int(config.OPT)
    options.slp_vectorization = bool(config.SLP_VECTORIZE)
    options.loop_vectorization = bool(config.LOOP_VECTORIZE)
    return llvm.create_pass_builder(machine, options)


def array_in_one_piece(context: Any, builder: Any, kind: Any, address: Any, lengths: Any) -> Any:
    """Return an array of numba's in one piece, whose memory, at an address, is someone else's."""
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
