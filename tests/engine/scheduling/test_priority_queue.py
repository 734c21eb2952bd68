"""Tests that the priority queue agrees with a search in a list, for any number of balls."""

import math

import numpy as np
from hypothesis import given, strategies as st
from kernels import entry_to

from ghostball.engine.core.state import NOWHERE
from ghostball.engine.scheduling.priority_queue import enter_instant, first_due, least_of_others

enter_instant, first_due, least_of_others = map(
    entry_to, (enter_instant, first_due, least_of_others)
)

INSTANTS = st.lists(st.sampled_from([0.0, 1.0, 2.0, 3.0, math.inf]), min_size=1, max_size=20)


def tree_of(instants):
    tree = np.full(2 << (len(instants) - 1).bit_length(), np.inf)
    for i, instant in enumerate(instants):
        enter_instant(tree, i, instant)
    return tree


@given(INSTANTS, st.sampled_from([0.0, 1.0, 2.5]), st.integers(0, 20))
def test_the_first_that_is_due(instants, t, start):
    due = [i for i, instant in enumerate(instants) if instant <= t and i >= start]
    assert first_due(tree_of(instants), t, start) == (due[0] if due else NOWHERE)


@given(INSTANTS, st.data())
def test_the_earliest_of_all_others(instants, data):
    i = data.draw(st.integers(0, len(instants) - 1))
    others = instants[:i] + instants[i + 1 :]
    assert least_of_others(tree_of(instants), i) == min(others, default=math.inf)


@given(INSTANTS, st.data())
def test_a_changed_instant_reaches_the_root(instants, data):
    tree = tree_of(instants)
    i = data.draw(st.integers(0, len(instants) - 1))
    instants[i] = 1.5
    enter_instant(tree, i, 1.5)
    assert np.array_equal(tree, tree_of(instants))
    assert tree[1] == min(instants)
