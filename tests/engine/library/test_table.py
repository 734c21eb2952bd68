"""Tests of the table that passes arguments to a kernel."""

from typing import NamedTuple

import numpy as np
import pytest

from ghostball.engine.library import table
from ghostball.engine.library.table import Layout, dtype_of, flat, kind_of, kind_of_result


class Pair(NamedTuple):
    first: float
    second: tuple[int, bool]


PAIR = ["named", f"{__name__}:Pair", ["float", ["tuple", ["int", "bool"]]]]
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
        ((1, None), ["tuple", ["int", "none"]]),
        (
            Pair(1.0, (2, True)),
            ["named", f"{__name__}:Pair", ["float", ["tuple", ["int", "bool"]]]],
        ),
    ],
)
def test_what_an_argument_is(value, kind):
    assert kind_of(value) == kind
    if kind[0] == "array":
        assert dtype_of(kind[1]) == value.dtype


@pytest.mark.parametrize(
    "value", ["text", [1.0], {1: 2}, 1j, np.zeros(2, dtype=np.dtype("f8").newbyteorder())]
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
        ("tuple[float, bool]", ["tuple", ["float", "bool"]]),
        ("Pair", PAIR),
    ],
)
def test_what_a_kernel_returns(hint, kind):
    assert kind_of_result(returning(hint)) == kind


def test_what_no_kernel_returns():
    with pytest.raises(TypeError, match="a kernel can't return"):
        kind_of_result(returning("str"))


def test_tuples_are_taken_apart():
    assert flat((1, (2, (3,)), Pair(4.0, (5, True)))) == [1, 2, 3, 4.0, 5, True]


def test_a_table_has_a_word_for_each_number_and_array_and_none_for_none():
    kinds = [kind_of(one) for one in (1, None, 0.5, (True, np.zeros(3)))]
    layout = Layout(kinds, kind_of_result(returning("tuple[int, float]")))
    assert layout.first == table.AT_RESULT + 2
    assert layout.length == layout.first + 4
    words = np.zeros(layout.length, dtype=np.int64)
    layout.pack(words, 0, *layout.head, 1, 0.5, np.bool_(True), 77)
    assert list(words[:4]) == [table.VERSION, layout.length, object.__basicsize__, table.REFUSED]
    assert words[layout.first] == 1
    assert words[layout.first + 1 :].view(np.float64)[0] == 0.5
    assert list(words[layout.first + 2 :]) == [1, 77]
    words[table.AT_RESULT] = -7
    words[table.AT_RESULT + 1 :].view(np.float64)[0] = 2.5
    assert layout.result(words) == (-7, 2.5)


def test_results_keep_their_type_and_value():
    kind = kind_of_result(returning("Pair"))
    words = np.zeros(table.AT_RESULT + 3, dtype=np.int64)
    words[table.AT_RESULT :].view(np.float64)[0] = 1.5
    words[table.AT_RESULT + 1 :] = 4, 1
    found = Layout([], kind).result(words)
    assert found == Pair(1.5, (4, True))
    assert isinstance(found.second[1], bool)
