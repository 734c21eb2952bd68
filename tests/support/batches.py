"""Compare a batch of shots with single runs."""

from __future__ import annotations

import numpy as np
from shots import POOL_TABLE, ball, scene_of

from ghostball.engine import STATUSES, Batch
from ghostball.model import EventKind, Result, Scene


def two_ball_shot(velocity=(2.0, 0.0), **cue) -> Scene:
    cue_ball = ball((0.6, 0.6), velocity, **cue)
    return scene_of(cue_ball, ball((1.6, 0.635)), table=POOL_TABLE, preset="pool")


def assert_same(batch: Batch, k: int, result: Result) -> None:
    """Assert that shot k of a batch is bit-identical to the result of a single run."""
    n = len(result.scene.balls)
    assert np.array_equal(batch.rest_positions[k, :n], result.rest_positions)
    assert np.all(np.isnan(batch.rest_positions[k, n:]))
    assert batch.rest_times[k] == result.rest_time
    assert batch.ball_ball[k] == result.collision_counts["ball-ball"]
    assert batch.ball_cushion[k] == result.collision_counts["ball-cushion"]
    assert batch.events[k] == result.work["events"]
    assert STATUSES[batch.status[k]] is result.status


OUTCOMES = (
    "pocketed",
    "pocketed_at",
    "off_table",
    "first_contact",
    "cushions_before",
    "ball_cushions",
)
"""The attributes of a batch that have a value for each ball, except the rest positions."""


def outcomes_of(result: Result) -> dict[str, np.ndarray]:
    """Return the outcomes of one shot by name, counted from its recorded events, each (n,)."""
    n = len(result.scene.balls)
    pocketed, first = np.full(n, -1), np.full(n, -1)
    pocketed_at, off_table = np.full(n, np.nan), np.zeros(n, dtype=bool)
    before, cushions = np.zeros(n, dtype=int), np.zeros(n, dtype=int)
    for t, kind, a, b in result.events.tolist():
        if kind == EventKind.BALL_CUSHION:
            cushions[a] += 1
            before[a] += first[a] < 0
        elif kind == EventKind.BALL_BALL:
            first[a] = b if first[a] < 0 else first[a]
            first[b] = a if first[b] < 0 else first[b]
        elif kind == EventKind.POCKETED:
            pocketed[a], pocketed_at[a] = b, t
        elif kind == EventKind.LEAVES_TABLE:
            off_table[a] = True
    return dict(
        zip(OUTCOMES, (pocketed, pocketed_at, off_table, first, before, cushions), strict=True)
    )


def assert_same_outcomes(batch: Batch, k: int, result: Result) -> None:
    """Assert that the outcomes of shot k of a batch are those of a shot with recorded events.

    The result's own outcomes must be the same.
    """
    n, cue = len(result.scene.balls), k % len(result.scene.balls)
    of_result = result.outcomes(cue)
    for name, expected in outcomes_of(result).items():
        of_cue = name in {"first_contact", "cushions_before"}
        np.testing.assert_array_equal(getattr(batch, name)[k, :n], expected, err_msg=name)
        np.testing.assert_array_equal(
            getattr(of_result, name), expected[cue] if of_cue else expected, err_msg=name
        )
