"""Tests of calls that a compiled kernel refuses, without writing anything."""

import numpy as np
import pytest

from ghostball.engine.library import table
from ghostball.engine.library.entry import COMPILED, WrongArgumentError
from ghostball.reference_adapters.stepping import slowing

compiled = pytest.mark.skipif(not COMPILED, reason="interpreted kernels take any argument")
V = np.array([[1.0, 0.0], [0.0, 2.0], [0.0, 0.0]])
SLOWING = np.array([0.2, 0.4, 0.3])


@compiled
@pytest.mark.parametrize(
    ("arguments", "place"),
    [
        ((V[:, ::-1], SLOWING, np.empty(3)), 1),
        ((V.T.copy().T, SLOWING, np.empty(3)), 1),
        ((V, np.empty(6)[::2], np.empty(3)), 2),
        ((V, SLOWING, np.frombuffer(bytes(25), np.uint8)[1:].view(np.float64)), 3),
    ],
)
def test_an_array_that_is_not_in_one_piece_is_refused(arguments, place):
    with pytest.raises(WrongArgumentError, match=f"argument {place} of the kernel `stop`"):
        slowing.stop(*arguments)


@compiled
@pytest.mark.parametrize(
    "changed",
    [
        lambda times: times.astype(np.int64),
        lambda times: times[:, np.newaxis],
        lambda times: times.view(np.dtype([("t", np.float64)])),
    ],
)
def test_a_bound_kernel_refuses_arrays_of_another_type_and_writes_nothing(changed):
    times = np.full(3, 7.0)
    other = changed(times)
    call = slowing.stop.bind(V, SLOWING, times)
    table_of = call._table
    table_of[len(table_of) - 1] = id(other)
    call._arguments = (V, SLOWING, other)
    with pytest.raises(WrongArgumentError, match="argument 3 of the kernel `stop`"):
        call()
    assert np.all(np.asarray(times) == 7.0)


@compiled
@pytest.mark.parametrize("place", [table.AT_VERSION, table.AT_LENGTH])
def test_another_version_or_length_of_the_table_is_refused_and_nothing_written(place):
    """Otherwise a library of another version would read addresses where there are none."""
    times = np.full(3, 7.0)
    call = slowing.stop.bind(V, SLOWING, times)
    call._table[place] += 1
    with pytest.raises(WrongArgumentError, match="needs another table than version"):
        call()
    assert np.all(times == 7.0)
