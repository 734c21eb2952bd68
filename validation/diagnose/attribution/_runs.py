"""Run an engine at other steps, and at inputs an ulp away."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import Ball, GhostballError, Scene, SceneError
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.diagnose.attribution._zero_step import LEAST_RATIO, RUNS
from ghostball.validation.grading.event_logs import (
    Agreement,
    Event,
    compare_logs,
    events_in,
)
from ghostball.validation.runs.playing import run_engine
from ghostball.validation.runs.rolling import rolling_spin
from ghostball.validation.runs.sampling import events_of
from ghostball.validation.runs.steps import step_setting

FloatArray = NDArray[np.float64]

ULPS = 2
"""Runs whose input is an ulp away."""

STEPS = 300_000
"""Steps that a ladder may take in all; where none takes as few, the shortest one is run."""

FINEST = (256, 128, 64, 32, 16, 8)
"""Into how many parts the finest run divides the engine's step, from the dearest ladder on."""


def ladder_of(step: float, duration: float, end: float | None) -> list[float]:
    """Return the steps of a ladder [s], falling: the engine's own, `RUNS` in all, and the finest.

    Parameters
    ----------
    step : float [s]
        The engine's own.
    duration : float [s]
        Of the shot, which says how fine a ladder is affordable.
    end : float or None [s]
        Where the scene ends by its `t_max`: each step is then shortened to divide it, for engines
        do so each in its own way.

    Notes
    -----
    The steps are spread evenly between the engine's own and twice the finest: shorter ones cost
    more, and tell no more. A contact falls anywhere into a step, and into another part of each.
    """
    steps: list[float] = []
    for finest in FINEST:
        shares = [*np.linspace(1.0, LEAST_RATIO / finest, RUNS).tolist(), 1.0 / finest]
        steps = [step * share for share in shares]
        if duration * sum(1.0 / one for one in steps) <= STEPS:
            break
    if end is None:
        return steps
    counts = [math.ceil(end / one) for one in steps]
    counts[-1] = max(counts[-1], math.ceil(LEAST_RATIO * counts[-2]))
    return [end / count for count in counts]


@dataclass(frozen=True, eq=False)
class Played:
    """One run of a ladder.

    Attributes
    ----------
    step : float [s]
    collisions : list of Event
    positions : (n, 2) float64 [m]
        Centres at the end.
    """

    step: float
    collisions: list[Event]
    positions: FloatArray


class StoppedEarlyError(GhostballError):
    """A run that did not come to its natural end, so that there is nothing to compare."""


def play(engine: ReferenceEngine, scene: Scene) -> Played:
    """Run a scene.

    Raises
    ------
    StoppedEarlyError
        Where the run doesn't come to its end.
    """
    result = run_engine(engine, scene, "events")
    if not result.status.complete:
        raise StoppedEarlyError(
            f'engine `{engine.name}` stopped early in scene "{scene.name}": '
            f"{result.reason or result.status.value}"
        )
    step = float(result.settings.get(step_setting(engine) or "", 0.0) or 0.0)
    return Played(step, events_in(events_of(result)), result.rest_positions[:, :2])


def play_ulps(engine: ReferenceEngine, scene: Scene, count: int) -> list[Played]:
    """Run the scene with the moving balls' positions and velocities an ulp away, up or down."""
    return [play(engine, moved) for moved in ulps_away(scene, count)]


def ulps_away(scene: Scene, count: int) -> Iterator[Scene]:
    """Yield scenes whose moving balls start an ulp away; fewer where some would overlap.

    A number that is 0 stays 0.
    """
    # A generator of its own for each scene: the same runs whatever ran before.
    random = np.random.default_rng(0)
    for _ in range(count):
        balls = [_ulp_away(scene, i, random) for i in range(len(scene.balls))]
        try:
            yield Scene(**{**dict(scene), "balls": balls})
        except SceneError:  # it touched something, and an ulp nearer is inside it
            continue


def _ulp_away(scene: Scene, i: int, random: np.random.Generator) -> Ball:
    ball = scene.balls[i]
    if ball.speed == 0.0:
        return ball
    values = np.array([*ball.position[:2], *ball.velocity[:2]])
    ways = random.choice([-np.inf, np.inf], size=len(values))
    moved = np.where(values == 0.0, values, np.nextafter(values, ways)).tolist()
    changes: dict[str, Any] = {
        "position": (*moved[:2], ball.position[2]),
        "velocity": (*moved[2:], ball.velocity[2]),
    }
    if scene.rolls[i] and ball.angular_velocity is not None:
        spin = ball.angular_velocity[2]
        changes["angular_velocity"] = rolling_spin(changes["velocity"], ball.radius, spin)
    return Ball(**{**dict(ball), **changes})


def agreed_instant(
    true: Sequence[Event], runs: Sequence[Sequence[Event]], end: float
) -> float | None:
    """Return the last instant up to which logs agree with the true one, or None if to the `end`.

    Parameters
    ----------
    true : sequence of Event
    runs : sequences of Event
    end : float [s]
        Until when to compare; infinite is to the end of the runs.

    Notes
    -----
    The instant lies in the middle of the last stretch of time in which no run has a collision that
    another one had before, or has later: the length of a detection that is late would else be taken
    for an error.
    """
    agreements = [compare_logs(true, run) for run in runs]
    partings = [one.parting.t for one in agreements if one.parting is not None]
    parted = min(partings, default=math.inf)
    if math.isinf(end) and math.isinf(parted):
        return None
    if parted >= end and not any(_straddles(one, end) for one in agreements):
        return end
    stop = max(min(parted, end), 0.0)
    spans = [(min(a.t, b.t), max(a.t, b.t)) for one in agreements for a, b in one.pairs]
    free_from, best = 0.0, 0.0
    for first, last in sorted(spans):
        if first >= stop:
            break
        if first > free_from:
            best = 0.5 * (free_from + first)
        free_from = max(free_from, last)
    return 0.5 * (free_from + stop) if free_from < stop else best


def _straddles(agreement: Agreement, t: float) -> bool:
    return any(min(a.t, b.t) <= t <= max(a.t, b.t) for a, b in agreement.pairs)
