"""The engine against the oracle, event by event, as far as the shot's chaos allows.

How much an error at the start has grown by each event is measured, not guessed: the oracle plays
the shot again with every number nudged by about 1e-25, in 50 digits, where that is linear. Double
precision nudges by half a `EPS`, again at every event; `ROUNDINGS` allows for those.
"""

from __future__ import annotations

from dataclasses import dataclass

from invariants import EPS
from mpmath import mpf, workdps
from oracle import DIGITS, NUDGE, OracleRun, solve

from engine import Result, Scene, Status, simulate

ROUNDINGS = 64
"""Errors of EPS that a run may add up, amplified by the shot: some ten per event, twenty events.

The largest seen over 320 random shots, 3 364 events, was 6.0.
"""

CHAOS = 1e-6
"""Amplification times EPS beyond which nothing is compared."""


@dataclass(frozen=True)
class Agreement:
    """How far the comparison went, and the largest error in units of EPS times amplification."""

    events: int
    ball_collisions: int
    reached_the_end: bool
    worst_roundings: float


def check_against_oracle(scene: Scene, *, max_ball_collisions: int = 6) -> Agreement:
    """Assert that the engine finds the oracle's events, when they happen, and where all rests."""
    with workdps(DIGITS):
        result = simulate(scene, record="events")
        truth = solve(scene, max_ball_collisions=max_ball_collisions)
        nudged = [
            solve(scene, max_ball_collisions=max_ball_collisions, nudge_seed=seed)
            for seed in (1, 2)
        ]
        return _compare(scene, result, truth, nudged, max_ball_collisions)


def _compare(
    scene: Scene,
    result: Result,
    truth: OracleRun,
    nudged: list[OracleRun],
    max_ball_collisions: int,
) -> Agreement:
    assert result.events is not None
    growth, worst, ball_collisions = mpf(1), 0.0, 0
    for k, event in enumerate(truth.events):
        others = [run.events[k] for run in nudged]
        assert all(other.key == event.key for other in others), "a nudge of 1e-25 changed the shot"
        growth = max(growth, event.t, *(abs(other.t - event.t) / NUDGE for other in others))
        tolerance = ROUNDINGS * EPS * growth
        later = truth.events[k + 1].t if k + 1 < len(truth.events) else event.t + 1
        if growth * EPS > CHAOS or later - event.t < 2 * tolerance:
            return Agreement(k, ball_collisions, False, worst)
        assert k < len(result.events), f"missed {event.key} at t = {float(event.t)} s"
        found = result.events[k]
        assert (int(found["kind"]), int(found["a"]), int(found["b"])) == event.key, (
            f"event {k}: {found} instead of {event.key} at t = {float(event.t)} s"
        )
        error = abs(mpf(float(found["t"])) - event.t)
        worst = max(worst, float(error / (EPS * growth)))
        assert error <= tolerance, f"event {k}, {found}: {worst:.1f} roundings"
        ball_collisions += event.kind == 0
    if ball_collisions == max_ball_collisions:
        return Agreement(len(truth.events), ball_collisions, False, worst)
    assert result.status is (Status.REST if scene.t_max is None else Status.T_MAX)
    assert len(result.events) == len(truth.events), "an event too many"
    for i, place in enumerate(truth.positions):
        for axis in range(2):
            moved = [abs(run.positions[i][axis] - place[axis]) / NUDGE for run in nudged]
            growth_here = max(growth, abs(place[axis]), *moved)
            error = abs(mpf(float(result.rest_positions[i, axis])) - place[axis])
            worst = max(worst, float(error / (EPS * growth_here)))
            assert error <= ROUNDINGS * EPS * growth_here, f"ball {i} rests elsewhere"
    return Agreement(len(truth.events), ball_collisions, True, worst)
