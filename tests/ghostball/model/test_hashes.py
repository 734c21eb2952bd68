"""Hashes: another bit, another hash; they must hold on every platform and for ever."""

from __future__ import annotations

import numpy as np
import pytest

from ghostball.model import EVENT_DTYPE, EventKind
from ghostball.model.hashes import bits_hash, sequence_hash

EVENTS = np.array(
    [(0.25, EventKind.BALL_BALL, 0, 1), (0.5, EventKind.ROLL_TO_REST, 1, -1)], dtype=EVENT_DTYPE
)
PLACES = np.array([[0.5, 0.25, 0.0], [1.0, 2.0, 0.0]])


def test_the_hashes_are_what_they_were():
    # A hash that means something else makes every baseline say that all results changed.
    assert bits_hash(EVENTS, PLACES) == (
        "35b65969dcbe6aa4a10842730bf38e99714b46ff44a429a53eb9648556b625e1"
    )
    assert sequence_hash(EVENTS) == (
        "1be9a5b603bc4529a804e122ff7c0805e002c04bc4e6da46bc277449e29cbea8"
    )


def test_only_0_and_minus_0_are_one_place():
    assert bits_hash(EVENTS, PLACES * np.array([1.0, 1.0, -1.0])) == bits_hash(EVENTS, PLACES)
    moved = PLACES.copy()
    moved[1, 1] = np.nextafter(2.0, 3.0)
    assert bits_hash(EVENTS, moved) != bits_hash(EVENTS, PLACES)


def test_places_in_another_layout_of_memory_are_the_same_places():
    assert bits_hash(EVENTS, np.asfortranarray(PLACES)) == bits_hash(EVENTS, PLACES)
    padded = np.dtype([("b", "<i4"), ("t", "<f8"), ("kind", "<i8"), ("a", "<i4")])
    other = np.empty(2, dtype=padded)
    for name in padded.names:
        other[name] = EVENTS[name]
    assert bits_hash(other, PLACES) == bits_hash(EVENTS, PLACES)
    assert sequence_hash(other) == sequence_hash(EVENTS)


@pytest.mark.parametrize("column", EVENT_DTYPE.names)
def test_every_column_counts_and_the_order_of_events_has_no_instants(column):
    other = EVENTS.copy()
    other[column][0] = np.nextafter(0.25, 1.0) if column == "t" else 3
    assert bits_hash(other, PLACES) != bits_hash(EVENTS, PLACES)
    assert (sequence_hash(other) == sequence_hash(EVENTS)) == (column == "t")


def test_two_events_that_swap_places_have_another_hash():
    assert sequence_hash(EVENTS[::-1]) != sequence_hash(EVENTS)
