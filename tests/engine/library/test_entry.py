"""Tests of calls of a kernel from Python: same results as the function, and no wrong write."""

import pickle
import subprocess
import sys

import numpy as np
import pytest

from ghostball.engine.library import load, table
from ghostball.engine.library.entry import COMPILED, Entry, Needed, WrongArgumentError
from ghostball.engine.library.table import kind_of
from ghostball.reference_adapters.stepping import slowing

compiled = pytest.mark.skipif(not COMPILED, reason="interpreted kernels take any argument")

V = np.array([[1.0, 0.0], [0.0, 2.0], [0.0, 0.0]])
SLOWING = np.array([0.2, 0.4, 0.3])


def test_a_call_does_what_the_function_does():
    found, expected = np.empty(3), np.empty(3)
    slowing.stop(V, SLOWING, found)
    slowing.stop.function(V, SLOWING, expected)
    np.testing.assert_array_equal(found, expected)


def test_a_bound_call_can_be_made_again():
    times = np.zeros(3)
    call = slowing.stop.bind(V, SLOWING, times)
    for _ in range(2):
        times[:] = 7.0
        call()
        np.testing.assert_array_equal(times, [5.0, 5.0, 0.0])


@compiled
def test_a_kernel_with_an_index_outside_an_array_is_not_run_again(monkeypatch):
    slowing.stop(V, SLOWING, np.empty(3))
    calls = []

    def goes_beyond(_status, _raised, made):
        made._obj[table.AT_STATUS] = table.ENTERED
        calls.append(made)
        return 1

    (code,) = {id(one): one for one in slowing.stop._by_types.values()}.values()
    monkeypatch.setattr(code, "entry", goes_beyond)
    with pytest.raises(IndexError, match="kernel `stop` used an index outside an array"):
        slowing.stop(V, SLOWING, np.empty(3))
    assert len(calls) == 1


def test_an_entry_is_pickled_by_its_name():
    assert pickle.loads(pickle.dumps(slowing.stop)) is slowing.stop


@compiled
def test_the_same_types_of_other_dimensions_are_another_variant(monkeypatch):
    """Only the kernel detects the other dimensions; then the library for them is searched."""
    asked = []
    monkeypatch.setattr(Entry, "code_for", lambda self, arguments: asked.append(arguments) or CODE)
    one = Entry(slowing.stop.function)
    one._by_types[(np.ndarray,) * 3] = CODE = slowing.stop.bind(V, SLOWING, np.empty(3)).code
    with pytest.raises(WrongArgumentError):
        one(V, SLOWING, V)
    assert [[a.ndim for a in arguments] for arguments in asked] == [[2, 1, 2]]


def test_a_needed_kernel_knows_whether_it_is_made(monkeypatch):
    one = Needed(slowing.stop, (V, SLOWING, np.empty(3)), "durations")
    one.load()
    assert one.is_made
    monkeypatch.setattr(load, "find", lambda *_: None)
    assert one.is_made == (not COMPILED)
    assert one.kinds == [kind_of(V), kind_of(SLOWING), kind_of(SLOWING)]


WITHOUT_NUMBA = """
import sys
sys.modules["numba"] = sys.modules["llvmlite"] = None
from ghostball import Ball, Scene, simulate
balls = [Ball(id="cue", position=(0, 0), velocity=(1, 0)), Ball(id="1", position=(1, 0))]
result = simulate(Scene(name="roll", balls=balls), record="trajectory")
result.sensitivity(result.rest_time)
print(result.status.name)
"""


def test_a_run_imports_no_numba():
    command = [sys.executable, "-c", WITHOUT_NUMBA]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.stdout == "REST\n", done.stderr
