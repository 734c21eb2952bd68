"""Where a difference comes from: the engine's step, its model, or rounding.

    >>> attribute(scene, make_engine("pymunk")).outcome
    'step'

A ladder of three steps says it: what goes away as the step gets shorter is the step's, what stays
is the model's, the physics that the engine lacks or has otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from pydantic import ValidationError

from ghostball.model import GhostballError, Result, Scene
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.checks.law import approximations_of
from ghostball.validation.grading.event_logs import Agreement, Event, compare_logs, events_in
from ghostball.validation.grading.horizon import growth_along, horizon
from ghostball.validation.grading.tolerances import ROUNDINGS, UNIT_ROUNDOFF
from ghostball.validation.runs.playing import run_engine
from ghostball.validation.runs.sampling import events_of
from ghostball.validation.runs.steps import step_of, with_setting, with_step
from ghostball.validation.truth.known_shot import KnownBy, KnownShot, known_shot
from ghostball.validation.truth.proof import proof_of

Outcome = Literal["step", "model", "rounding", "not compared"]
"""What a difference comes from, for the most part."""

FINER: Final = 4.0
"""How many times shorter each step of a ladder is than the one before."""

RUNGS: Final = 3

GOES_AWAY: Final = 0.5
"""A difference goes away where the shortest step leaves at most this part of it.

A step sees a contact late by any part of it: a ball's error over the step is as good as random. So
the largest difference at the two longer steps is compared with that at a sixteenth: where it is the
step's, it stays above this part in one shot of fifty, by chance.
"""

ATTEMPTS: Final = 8
"""How often an earlier instant is tried, because a run that is made anew parts before it."""

EARLIEST: Final = 1e-6
"""Instants before this are the start [s]: nothing has happened."""

PREDICTABLE: Final = 1e-6
"""How far rounding may move a ball before the shot counts as unpredictable [m].

A thousandth of what the best stepping engine is off, so that chaos isn't taken for its errors.
"""


@dataclass(frozen=True)
class Rung:
    """A run of a ladder: its step [s], and how far the worst ball then was from the truth [m]."""

    step: float
    difference: float


@dataclass(frozen=True)
class Attribution:
    """Where the difference of one engine in one scene comes from.

    `scene`, `label`, `engine`: as in a `CaseRecord`.
    `truth`: what it is the difference from.
    `reason`: where nothing could be compared, why; else "".
    `instant` [s]: when the balls were compared; None is at the end.
    `until`: why not at the end; else "".
    `difference` [m]: largest distance of a ball from the truth.
    `rounding` [m]: what roundings may have moved a ball by; None where no derivative says it.
    `approximations`: what of this scene the engine says that it represents only approximately.
    `ladder`: from the engine's own step to the shortest; empty where it has none.
    `with_exact_steps` [m]: the difference where steps end exactly at contacts, where the engine can
        do that.
    """

    scene: str
    label: str
    engine: str
    outcome: Outcome
    truth: KnownBy
    reason: str = ""
    instant: float | None = None
    until: str = ""
    difference: float | None = None
    rounding: float | None = None
    approximations: tuple[str, ...] = ()
    ladder: tuple[Rung, ...] = ()
    with_exact_steps: float | None = None


class NotComparedError(GhostballError):
    """Runs of which nothing can be compared with the truth."""


def attribute(
    scene: Scene, engine: ReferenceEngine, *, label: str = "", known: KnownShot | None = None
) -> Attribution:
    """Say where the difference of an engine from the truth comes from.

    `label`: the engine as asked for; its name where it is left out.
    `known`: the true shot, where the caller has it.

    Raises `UnsupportedSceneError` where the engine, or the truth, lacks a feature of the scene;
    `GhostballError` where the truth comes to no end.

    Balls are compared where they end, as long as every run has the collisions of the truth, ball
    by ball, and the shot is predictable; else at the last instant of which both hold, to which the
    engine is run anew.
    """
    known = known_shot(scene) if known is None else known
    found = Attribution(
        scene.name,
        label or engine.name,
        engine.name,
        "not compared",
        known.kind,
        approximations=approximations_of(engine, scene),
    )
    step = step_of(engine)
    steps = [] if step is None else [step / FINER**k for k in range(RUNGS)]
    growth = growth_along(scene, proof_of(scene)[0], known.result)
    predictable = horizon(growth, PREDICTABLE, ROUNDINGS * UNIT_ROUNDOFF)
    engines = [engine, *(with_step(engine, one) for one in steps[1:])]
    try:
        runs, instant = _compared(engines, known, predictable)
    except NotComparedError as error:
        return replace(found, reason=str(error))
    if instant is not None:
        early = instant < predictable
        until = "the collisions of some run of the ladder are others from then on"
        found = replace(
            found,
            instant=instant,
            until=until if early else "past it, roundings move a ball by more than a micrometre",
        )
    truth = known.positions(instant)
    differences = [largest_distance(run.rest_positions[:, :2], truth) for run in runs]
    found = replace(
        found,
        difference=differences[0],
        ladder=tuple(map(Rung, steps, differences)),
        with_exact_steps=_with_exact_steps(engine, known, instant),
    )
    t = known.result.rest_time if instant is None else instant
    size = float(np.max(growth.sizes([t])))
    if math.isfinite(size):
        taken = 0.0 if step is None else t / step
        rounding = ROUNDINGS * UNIT_ROUNDOFF * size * (1.0 + taken)
        found = replace(found, rounding=rounding)
        if differences[0] <= rounding:
            return replace(found, outcome="rounding")
    goes = step is not None and differences[-1] <= GOES_AWAY * max(differences[:-1])
    return replace(found, outcome="step" if goes else "model")


def largest_distance(a: FloatArray, b: FloatArray) -> float:
    """Return the largest distance of a ball between two states (n, 2) [m]."""
    return float(np.max(np.hypot(*(a - b).T)))


def _compared(
    engines: Sequence[ReferenceEngine], known: KnownShot, predictable: float
) -> tuple[list[Result], float | None]:
    """Run engines to the last instant up to which all agree with the truth; None: to the end.

    Raises `NotComparedError` where there is none, or a run doesn't come to its end.
    """
    true, instant = events_in(events_of(known.result)), None
    for _ in range(ATTEMPTS):
        shot = _until(known.scene, instant)
        runs = [_play(engine, shot) for engine in engines]
        logs = [events_in(events_of(run)) for run in runs]
        before = [one for one in true if instant is None or one.t <= instant]
        agreed = agreed_instant(before, logs, predictable if instant is None else math.inf)
        if agreed is None:
            return runs, instant
        if agreed < EARLIEST:
            break
        instant = agreed
    raise NotComparedError(
        f"engine `{engines[0].name}` and the truth part before any instant at which they could be "
        "compared"
    )


def _until(scene: Scene, instant: float | None) -> Scene:
    return scene if instant is None else scene.model_copy(update={"t_max": instant})


def _play(engine: ReferenceEngine, scene: Scene) -> Result:
    """Run a scene.

    Raises `NotComparedError` where the run doesn't come to its end.
    """
    result = run_engine(engine, scene, "events")
    if not result.status.complete:
        raise NotComparedError(
            f'engine `{engine.name}` stopped early in scene "{scene.name}": '
            f"{result.reason or result.status.value}"
        )
    return result


def _with_exact_steps(
    engine: ReferenceEngine, known: KnownShot, instant: float | None
) -> float | None:
    """Return the difference where steps end at contacts; None where the engine can't do that."""
    if getattr(engine.settings, "contact_steps", None) != "fixed":
        return None
    try:
        exact = with_setting(engine, "contact_steps", "exact")
        result = _play(exact, _until(known.scene, instant))
    except (NotComparedError, ValidationError):
        return None  # no better way to play it, or none with its other settings
    return largest_distance(result.rest_positions[:, :2], known.positions(instant))


def agreed_instant(
    true: Sequence[Event], runs: Sequence[Sequence[Event]], end: float
) -> float | None:
    """Return the last instant up to which logs agree with the true one, or None if to the `end`.

    `end` [s]: until when to compare; infinite is to the end of the runs.

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
