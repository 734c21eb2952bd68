"""Breaks that make a ball: the same number is the same break, and counts are of all of them."""

from __future__ import annotations

from benchmarks.made import break_of, measure_made
from ghostball.engine import simulate
from ghostball.model import EventKind


def test_a_number_is_a_break():
    assert break_of(3) == break_of(3)
    assert break_of(3) != break_of(4)
    assert len(break_of(3).balls) == 16


def test_counts_are_of_all_breaks():
    done = []
    measured = measure_made(6, progress=lambda *so_far: done.append(so_far))
    fell = []
    for number in range(6):
        events = simulate(break_of(number), record="events").events
        assert events is not None
        fell.append(events["a"][events["kind"] == EventKind.POCKETED].tolist())
    assert measured.pocketed == sum(map(len, fell))
    assert measured.made == sum(any(ball > 0 for ball in balls) for balls in fell)
    assert measured.scratched == sum(0 in balls for balls in fell)
    assert done[-1] == (6, 6, "breaks")
