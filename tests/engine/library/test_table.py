"""Tests of the table that passes arguments to a kernel."""

import ctypes
import struct

import numpy as np
import pytest

from ghostball.engine.library import table
from ghostball.engine.library.table import Layout, dtype_of, kind_of, kind_of_result

RECORD = np.dtype([("x", np.float64), ("y", np.float64)])


@pytest.mark.parametrize(
    ("value", "kind"),
    [
        (None, "none"),
        (True, "bool"),
        (np.bool_(False), "bool"),
        (3, "int"),
        (np.int64(3), "int"),
        (0.5, "float"),
        (np.float64(0.5), "float"),
        (np.zeros((2, 3)), ["array", "f8", 2]),
        (np.zeros(2, dtype=np.bool_), ["array", "b1", 1]),
        (np.zeros(2, dtype=RECORD), ["array", [["x", "<f8"], ["y", "<f8"]], 1]),
    ],
)
def test_what_an_argument_is(value, kind):
    assert kind_of(value) == kind
    if kind[0] == "array":
        assert dtype_of(kind[1]) == value.dtype


@pytest.mark.parametrize(
    "value", ["text", [1.0], (1.0,), {1: 2}, 1j, np.zeros(2, dtype=np.dtype("f8").newbyteorder())]
)
def test_what_no_kernel_can_be_given(value):
    with pytest.raises(TypeError, match="a kernel can't take "):
        kind_of(value)


def returning(hint):
    def function():
        pass

    function.__annotations__["return"] = hint
    return function


@pytest.mark.parametrize(
    ("hint", "kind"),
    [
        (None, "none"),
        ("None", "none"),
        ("int", "int"),
        ("float", "float"),
        (bool, "bool"),
    ],
)
def test_what_a_kernel_returns(hint, kind):
    assert kind_of_result(returning(hint)) == kind


@pytest.mark.parametrize("hint", ["str", "tuple[int, float]"])
def test_what_no_kernel_returns(hint):
    with pytest.raises(TypeError, match="a kernel can't return"):
        kind_of_result(returning(hint))


def test_a_table_has_a_word_for_each_number_and_array_and_none_for_none():
    kinds = [kind_of(one) for one in (1, None, 0.5, True, np.zeros(3))]
    layout = Layout(kinds, kind_of_result(returning("int")))
    assert layout.length == table.AT_FIRST + 4
    words = np.zeros(layout.length, dtype=np.int64)
    layout.pack(words, 0, *layout.head, 1, 0.5, np.bool_(True), 77)
    assert list(words[:4]) == [table.VERSION, layout.length, object.__basicsize__, table.REFUSED]
    assert words[table.AT_FIRST] == 1
    assert words[table.AT_FIRST + 1 :].view(np.float64)[0] == 0.5
    assert list(words[table.AT_FIRST + 2 :]) == [1, 77]


@pytest.mark.parametrize("result", [None, True, False, -7, 2.5])
def test_results_keep_their_type_and_value(result):
    hint = None if result is None else type(result)
    words = (ctypes.c_int64 * table.AT_FIRST)()
    form = "d" if isinstance(result, float) else "q"
    struct.pack_into(form, words, 8 * table.AT_RESULT, result or 0)
    found = Layout([], kind_of_result(returning(hint))).result(words)
    assert found == result
    assert type(found) is type(result)
