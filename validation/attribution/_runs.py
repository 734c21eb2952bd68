"""Run an engine at other steps, begun at other phases of them, and at inputs an ulp away."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine import Ball, GhostballError, Result, Scene, SceneError
from reference_adapters import ReferenceEngine
from validation.attribution._phases import begun_earlier
from validation.parting import Agreement, Collision, collisions_in, compare_logs
from validation.playing import run_engine
from validation.rolling import rolling_spin
from validation.sampling import events_of
from validation.steps import step_setting, with_step

FloatArray = NDArray[np.float64]

ULPS = 2
"""Runs whose input is an ulp away."""

STEPS = 40_000
"""Steps that a ladder may take in all; one that would take more gets the shortest plan."""


@dataclass(frozen=True)
class Plan:
    """How much is run.

    Attributes
    ----------
    phases : tuple of int
        For each level, how many start phases: the first level is the engine's own step, and each
        next one half of it.
    """

    phases: tuple[int, ...] = (3, 2, 1, 1)

    @property
    def work(self) -> int:
        """Runs, in units of one at the engine's own step."""
        return sum(count << level for level, count in enumerate(self.phases))


PLANS = (Plan((6,) * 7), Plan((6,) * 6), Plan((6,) * 5), Plan((4,) * 5), Plan())
"""From the dearest to the shortest.

A step sees a contact up to its length late; p phases leave of that at most h / 2p. So the shortest
plan has fewer at finer levels: what they leave is then about the same at each.
"""


def plan_for(duration: float, step: float) -> Plan:
    """Return the dearest plan for a shot of `duration` [s] that takes no more than `STEPS`."""
    steps = duration / step
    return next((plan for plan in PLANS if plan.work * steps <= STEPS), PLANS[-1])


@dataclass(frozen=True, eq=False)
class Played:
    """One run of a ladder.

    Attributes
    ----------
    step : float [s]
    lead : float [s]
        How much earlier it began than the scene does.
    collisions : list of Collision
        With times counted from the start of the scene.
    positions : (n, 2) float64 [m]
        Centres at the end.
    """

    step: float
    lead: float
    collisions: list[Collision]
    positions: FloatArray


class StoppedEarlyError(GhostballError):
    """A run that did not come to its natural end, so that there is nothing to compare."""


def play(engine: ReferenceEngine, scene: Scene, *, lead: float = 0.0) -> tuple[Played, Result]:
    """Run a scene that begins `lead` [s] early.

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
    collisions = [
        Collision(one.kind, one.a, one.b, one.t - lead) for one in collisions_in(events_of(result))
    ]
    step = float(result.settings.get(step_setting(engine) or "", 0.0) or 0.0)
    return Played(step, lead, collisions, result.rest_positions[:, :2]), result


def play_level(
    engine: ReferenceEngine, scene: Scene, step: float, phases: int, *, first: bool = True
) -> list[Played]:
    """Run the scene at a step, from each of the start phases that there is.

    There is always the first, that of the scene itself, unless it is left out.
    """
    stepped = with_step(engine, step)
    leads = [step * part / phases for part in range(phases)]
    starts = [(lead, begun_earlier(scene, lead)) for lead in (leads if first else leads[1:])]
    return [play(stepped, start, lead=lead)[0] for lead, start in starts if start is not None]


def play_ulps(engine: ReferenceEngine, scene: Scene, count: int) -> list[Played]:
    """Run the scene with the moving balls' positions and velocities an ulp away, up or down."""
    return [play(engine, moved)[0] for moved in ulps_away(scene, count)]


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
    true: Sequence[Collision], runs: Sequence[Sequence[Collision]], end: float
) -> float | None:
    """Return the last instant up to which logs agree with the true one, or None if to the `end`.

    Parameters
    ----------
    true : sequence of Collision
    runs : sequences of Collision
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
