"""Tests of internals of numba: they save time, and if they are missing nothing else is lost."""

import sys
from typing import NamedTuple

import numpy as np
import pytest
import small_kernel

from ghostball.engine.library import build
from ghostball.engine.library.entry import COMPILED
from ghostball.model.arrays import FloatArray

if not COMPILED:
    pytest.skip("interpreted kernels need no compiler", allow_module_level=True)

import numba

from ghostball.engine.library import numba_doors, plain_numba


@pytest.fixture(autouse=True)
def _as_in_a_new_process(monkeypatch):
    monkeypatch.setattr(build, "_WAY", [])


@pytest.fixture(scope="module")
def interpreted_bits():
    given = small_kernel.arguments()
    assert small_kernel.computed.function(*given) == 100
    return small_kernel.bits(given)


def test_a_kernel_is_compiled_by_all_doors(interpreted_bits, caplog):
    assert small_kernel.compiled_bits() == interpreted_bits
    way = build.way()
    assert type(way) is numba_doors.Doors, caplog.text
    # Callers pass 2, 3, and a count from an array of 32-bit integers.
    (power,) = way.kernels[small_kernel.power].overloads.values()
    assert type(power.library) is numba_doors._Code, "numba replaced the library of a kernel"
    assert power.library.made, "numba optimised a kernel that only others call"


def moves_a_module(patch):
    patch.setitem(sys.modules, "ghostball.engine.library.numba_doors", None)


def asks_for_an_argument(patch):
    patch.setattr(numba_doors._Compiler, "compile_extra", lambda *_, more: more)


def asks_for_a_method(patch):
    patch.setattr(numba_doors._Code, "__abstractmethods__", frozenset({"another"}))


def renames_what_a_module_has(patch):  # noticed while a called kernel is compiled
    patch.setattr(numba_doors._Code, "add_ir_module", lambda self, module: module.renamed)


def renames_what_a_call_resolves(patch):
    patch.setattr(numba_doors, "by_common_types", lambda dispatcher: dispatcher.renamed)


@pytest.mark.parametrize(
    "numba_changes",
    [
        moves_a_module,
        asks_for_an_argument,
        asks_for_a_method,
        renames_what_a_module_has,
        renames_what_a_call_resolves,
    ],
)
def test_a_missing_internal_of_numba_costs_time_but_no_bits(
    numba_changes, interpreted_bits, caplog, monkeypatch
):
    numba_changes(monkeypatch)
    assert small_kernel.compiled_bits() == interpreted_bits
    assert type(build.way()) is plain_numba.Plain
    (said,) = caplog.records
    assert "differs from what the engine knows" in said.getMessage()


@pytest.mark.parametrize("doors", [True, False])
def test_without_optimising_nothing_of_numbas_is_left(doors, interpreted_bits, monkeypatch):
    # Not a plain 0: some passes of numba ask this object for `is_opt_max`.
    monkeypatch.setattr("numba.config.OPT", type(numba.config.OPT)(0))
    monkeypatch.setattr(build, "_WAY", [numba_doors.Doors() if doors else plain_numba.Plain()])
    assert small_kernel.compiled_bits() == interpreted_bits


def test_a_mistake_in_a_kernel_raises_in_both_ways_to_compile(monkeypatch):
    def fail(*_):
        raise TypeError("an array too few")

    monkeypatch.setattr(numba_doors.Doors, "module", fail)
    monkeypatch.setattr(plain_numba.Plain, "module", fail)
    with pytest.raises(TypeError, match="an array too few"):
        small_kernel.compiled_bits()


def test_a_mistake_in_a_kernel_is_not_taken_for_a_change_in_numba(monkeypatch, caplog):
    def fail(_):
        raise TypeError("the kernel has optional arguments")

    monkeypatch.setattr(build, "reached_by", fail)
    with pytest.raises(TypeError, match="optional arguments"):
        small_kernel.compiled_bits()
    assert not caplog.records


class Heights(NamedTuple):
    x: FloatArray
    height: FloatArray | None


class Scene(NamedTuple):
    heights: Heights
    count: int


def highest(scene, i):
    heights = scene.heights
    if heights.height is not None and heights.height[i, 0] > heights.x[i]:
        return heights.height[i, 0]
    return heights.x[i]


@pytest.mark.parametrize("height", [None, np.array([[0.5], [2.0]])], ids=["none", "array"])
def test_code_for_a_field_that_is_none_is_left_out(height):
    """Without `_FieldsWithoutValue`, numba would look for the elements of None."""
    compiled = numba.njit(pipeline_class=plain_numba.Passes)(highest)
    scene = Scene(Heights(np.ones(2), height), 2)
    assert [compiled(scene, i) for i in range(2)] == [highest(scene, i) for i in range(2)]
