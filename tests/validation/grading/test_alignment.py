"""Event sequences that agree, miss, invent, tie and repeat themselves."""

from __future__ import annotations

import itertools
import random

import numpy as np
import pytest

import ghostball.validation.grading.alignment
from ghostball.engine import EventKind, Scene, simulate
from ghostball.engine.result import COLLISION_KINDS, Events
from ghostball.reference_adapters.certified import Choice, certify
from ghostball.validation.grading.alignment import (
    Alignment,
    Log,
    align,
    found_log,
    log_of,
    proved_log,
)
from ghostball.validation.scenes.library import find_scene

CHOICES = {
    "A": Choice(EventKind.BALL_BALL, 0, 1),
    "B": Choice(EventKind.BALL_CUSHION, 2, 0),  # no ball in common with A
    "C": Choice(EventKind.ROLL_TO_REST, 3, -1),  # nor with either
    "X": Choice(EventKind.BALL_BALL, 1, 2),  # one with A, one with B
}


def aligned(scene: Scene, events: Events) -> Alignment:
    """Align events of a scene with the proved ones."""
    return align(proved_log(certify(scene)), found_log(events))


def log(text: str) -> Log:
    """Events at 1, 2, 3 ... s; those in brackets at one instant; a digit says it outright."""
    choices, times, t, inside = [], [], 0.0, False
    for letter in text:
        if letter in "([":
            t, inside = t + 1.0, True
        elif letter in ")]":
            inside = False
        elif letter.isdigit():
            times[-1] = t = float(letter)
        else:
            t = t if inside else t + 1.0
            choices.append(CHOICES[letter])
            times.append(t)
    return log_of(choices, np.array(times))


@pytest.mark.parametrize(
    ("proved", "found", "missing", "invented"),
    [
        ("ABC", "ABC", [], []),
        ("", "", [], []),
        ("ABC", "", [0, 1, 2], []),
        ("", "AB", [], [0, 1]),
        ("ABC", "AC", [1], []),
        ("AC", "ABC", [], [1]),
        ("ABC", "AXC", [1], [1]),
        ("AB", "BA", [0], [1]),  # order counts: one of the two is out of place
        ("(AB)C", "BAC", [], []),  # at one instant in truth
        ("ABC", "(BA)C", [], []),  # the engine says nothing of their order
        ("(ABC)", "CBA", [], []),
        ("(AX)C", "XAC", [0], [1]),  # they share a ball: order counts at one instant, too
        ("(AXB)", "BAX", [2], [0]),  # B may not pass X
        ("(AB)", "BXA", [], [1]),  # only what is paired can be passed
        ("ABABAB", "ABAB", [4, 5], []),  # times 1, 2, 3, 4: the last two are missing
        ("A1B2A3B4A5", "A1B2A5", [2, 3], []),  # by the times
        ("A1A2A3", "A2A3", [0], []),
        ("A2A3", "A1A2A3", [], [0]),
        ("A1A2A3A4", "A1A3A4", [1], []),
        ("AAXBB", "AXB", [1, 4], []),  # times 1, 2 and 3: the earlier A, the earlier B
    ],
)
def test_what_has_no_partner(
    proved: str, found: str, missing: list[int], invented: list[int]
) -> None:
    alignment = align(log(proved), log(found))
    assert alignment.missing.tolist() == missing
    assert alignment.invented.tolist() == invented
    assert (alignment.first is None) == (not missing and not invented)


def test_the_first_difference_says_what_came_instead() -> None:
    alignment = align(log("ABC"), log("AXC"))
    first = alignment.first
    assert first is not None
    assert (first.what, first.index, first.event, first.t) == ("missing", 1, CHOICES["B"], 2.0)
    assert (first.competitor, first.competitor_t) == (CHOICES["X"], 2.0)
    names = ("one", "two", "three", "four")
    assert first.describe(names) == (
        'ball-cushion "three" with left at t = 2 s is proved but was not found; found in its '
        'place: ball-ball "two" with "three" at t = 2 s'
    )
    extra = align(log("A"), log("AB")).first
    assert extra is not None
    assert extra.competitor is None
    assert "the proved events end before it" in extra.describe(names)


def test_the_earlier_difference_is_the_first() -> None:
    first = align(log("ABCX"), log("ABBC")).first
    assert first is not None
    assert (first.what, first.index) == ("invented", 2)
    assert first.competitor == CHOICES["C"]


def check(alignment: Alignment, proved: Log, found: Log) -> None:
    """Whether it is an alignment at all: alike, each once, crossing only where they may."""
    pairs = list(zip(alignment.proved.tolist(), alignment.found.tolist(), strict=True))
    for i, j in pairs:
        assert proved.choices[i] == found.choices[j]
    assert sorted([*alignment.proved, *alignment.missing]) == list(range(len(proved)))
    assert sorted([*alignment.found, *alignment.invented]) == list(range(len(found)))
    for (i, j), (k, m) in itertools.combinations(pairs, 2):
        if (i < k) != (j < m):
            assert proved.windows[i] == proved.windows[k] or found.windows[j] == found.windows[m]
            balls = {proved.choices[n].a for n in (i, k)} | {
                proved.choices[n].b for n in (i, k) if proved.choices[n].kind == 0
            }
            assert len(balls) == sum(2 if proved.choices[n].kind == 0 else 1 for n in (i, k))


def shortest_edit(a: Log, b: Log) -> int:
    """Events without a partner, by the textbook's table."""
    table = [[i + j for j in range(len(b) + 1)] for i in range(len(a) + 1)]
    for i, j in itertools.product(range(1, len(a) + 1), range(1, len(b) + 1)):
        table[i][j] = min(table[i - 1][j], table[i][j - 1]) + 1
        if a.choices[i - 1] == b.choices[j - 1]:
            table[i][j] = min(table[i][j], table[i - 1][j - 1])
    return table[-1][-1]


@pytest.mark.parametrize("ties", [False, True])
def test_random_logs_are_aligned_as_well_as_by_the_table(ties: bool) -> None:
    chance = random.Random(f"alignment {ties}")
    for _ in range(400):
        logs = []
        for _ in range(2):
            events = chance.choices(list(CHOICES.values()), k=chance.randrange(12))
            times = np.cumsum([0.0 if ties and chance.random() < 0.4 else 1.0 for _ in events])
            logs.append(log_of(events, times))
        alignment = align(*logs)
        check(alignment, *logs)
        left_over = len(alignment.missing) + len(alignment.invented)
        if ties:
            assert left_over <= shortest_edit(*logs)
        else:
            assert left_over == shortest_edit(*logs)


def test_a_long_log_is_aligned_piece_by_piece(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ghostball.validation.grading.alignment, "PIECE", 8)
    chance = random.Random(5)
    whole = chance.choices("ABCX", k=300)
    kept = [letter for k, letter in enumerate(whole) if k % 17 != 3]  # every 17th is dropped
    proved = log_of([CHOICES[c] for c in whole], np.arange(300.0))
    found = log_of([CHOICES[c] for c in kept], np.array([k for k in range(300) if k % 17 != 3]))
    alignment = align(proved, found)
    check(alignment, proved, found)
    assert len(alignment.invented) == 0
    assert len(alignment.missing) == 300 - len(kept)
    nothing = align(log("AB" * 20), log("CX" * 30))
    assert len(nothing.proved) == 0
    apart = align(log("X"), log("A" * 40 + "X"))
    assert apart.proved.tolist() == [0]


def test_thousands_of_events_that_repeat_themselves() -> None:
    # Galperin's billiard: one pair, again and again; here every second log misses its beginning.
    n = 30_000
    events = [CHOICES["AX"[k % 2]] for k in range(n)]
    times = np.arange(float(n))
    alignment = align(log_of(events, times), log_of(events[2:], times[2:]))
    assert len(alignment.missing) == 2
    assert alignment.first is not None
    assert len(alignment.invented) == 0


@pytest.mark.parametrize("name", ["break-16", "follow-shot", "thirty-degree-rule", "galperin-2"])
def test_our_engine_finds_what_is_proved(name: str) -> None:
    scene = find_scene(name)
    events = simulate(scene, record="events").events
    assert events is not None
    alignment = aligned(scene, events)
    assert alignment.first is None
    assert alignment.proved.tolist() == list(range(len(events)))
    without = np.delete(events, 2)
    assert aligned(scene, without).missing.tolist() == [2]
    doubled = np.insert(events, 2, events[2])
    assert len(aligned(scene, doubled).invented) == 1


def test_an_engine_that_reports_collisions_only_is_aligned_by_these() -> None:
    scene = find_scene("break-7")
    events = simulate(scene, record="events").events
    assert events is not None
    collisions = events[np.isin(events["kind"], COLLISION_KINDS)]
    assert len(aligned(scene, collisions).missing) == len(events) - len(collisions)
    proved = proved_log(certify(scene))
    proved = proved.only(np.array([one.kind in COLLISION_KINDS for one in proved.choices]))
    assert align(proved, found_log(collisions)).first is None


def test_the_lower_ball_comes_first_in_a_log() -> None:
    scene = find_scene("half-ball-cut")
    events = simulate(scene, record="events").events
    assert events is not None
    swapped = events.copy()
    swapped["a"][0], swapped["b"][0] = events["b"][0], events["a"][0]
    assert found_log(swapped).choices == found_log(events).choices
    assert proved_log(certify(scene)).choices == found_log(events).choices
