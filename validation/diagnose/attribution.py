"""The cause of an engine's error: its time step, its model, or rounding.

    >>> attribute(scene, make_engine("pymunk")).outcome
    'step'

The engine plays the shot at its own step and at two shorter ones. An error that shrinks with the
step comes from the step. An error that stays comes from the model: physics that the engine lacks,
or has otherwise. If every run has the collisions of the reference, the errors are distances of the
balls at the end. If collisions differ, the errors are those of the times of the collisions that
all runs share.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
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
from ghostball.validation.runs.ladder import (
    run_with_step,
    shorter_steps,
    shrinks,
    with_setting,
)
from ghostball.validation.runs.sampling import events_of
from ghostball.validation.truth.known_shot import KnownBy, KnownShot, known_shot
from ghostball.validation.truth.proof import proof_of

Outcome = Literal["step", "model", "rounding", "agrees", "unseparated", "not compared"]
"""The main cause of an error.

"rounding": every collision is right, and the balls end where rounding allows. "agrees": the run
matches the reference as far as the two can be compared. "unseparated": collisions differ, and the
times of the shared ones don't say whether the step or the model is the cause.
"""

RUNGS: Final = 3
"""Steps that a shot is played with; a fourth decides where these contradict each other."""

VARIES: Final = 0.75
"""Largest relative change, from step to step, of an error that the model alone causes."""

ATTEMPTS: Final = 8
"""How often an earlier instant is tried, because a run that is made anew parts before it."""

EARLIEST: Final = 1e-6
"""Instants before this are the start [s]: nothing has happened."""

NEGLIGIBLE: Final = 1e-9
"""A smaller error isn't explained [m]: engines are expected to be right to nanometres."""

INSTANT: Final = 1e-9
"""A smaller time error of a collision isn't explained [s]: it is a nanometre at 1 m/s."""

PREDICTABLE: Final = 1e-6
"""How far rounding may move a ball before the shot counts as unpredictable [m].

A thousandth of what the best stepping engine is off, so that chaos isn't taken for its errors.
"""


@dataclass(frozen=True)
class Rung:
    """One run of the ladder of steps.

    `step` [s].
    `difference` [m]: largest distance of a ball from the reference; None if collisions differ.
    `late` [s]: largest error of the time of a collision that all runs share; None if there is none.
    `wrong_from` [s]: when its first wrong collision is; None if it has none.
    """

    step: float
    difference: float | None
    late: float | None = None
    wrong_from: float | None = None


@dataclass(frozen=True)
class Attribution:
    """Where the difference of one engine in one scene comes from.

    `scene`, `label`, `engine`: as in a `CaseRecord`.
    `truth`: what it is the difference from.
    `reason`: where nothing could be compared, why; else "".
    `instant` [s]: when the balls were compared, or when collisions first differ; None is the end.
    `until`: why the comparison ends there; else "".
    `difference` [m]: largest distance of a ball from the reference; None if collisions differ.
    `late` [s]: largest error of the time of a collision that all runs share.
    `shared`: how many collisions all runs share, if collisions differ.
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
    late: float | None = None
    shared: int = 0
    rounding: float | None = None
    approximations: tuple[str, ...] = ()
    ladder: tuple[Rung, ...] = ()
    with_exact_steps: float | None = None


class NotComparedError(GhostballError):
    """Runs of which nothing can be compared with the truth."""


def attribute(
    scene: Scene,
    engine: ReferenceEngine,
    *,
    label: str = "",
    known: KnownShot | None = None,
    run: Callable[[float | None], Result] | None = None,
) -> Attribution:
    """Say where the difference of an engine from the truth comes from.

    `label`: the engine as asked for; its name where it is left out.
    `known`: the true shot, where the caller has it.
    `run`: returns the engine's run of the scene with a step [s], None for its own; if the caller
        keeps such runs. They need their events.

    Raises `UnsupportedSceneError` where the engine, or the truth, lacks a feature of the scene;
    `GhostballError` where the truth comes to no end.

    Balls are compared where they end if every run has the collisions of the reference and the shot
    is predictable to its end. If the shot is predictable for a part only, the engine plays that
    part again. If collisions differ within that part, times of collisions are compared.
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
    steps = shorter_steps(engine, RUNGS)
    proof, _ = proof_of(scene)
    growth = growth_along(scene, proof, known.result)
    predictable = horizon(growth, PREDICTABLE, ROUNDINGS * UNIT_ROUNDOFF)
    limit = "after that, rounding moves a ball by more than a micrometre"
    open_ended = proof is not None and proof.ending in ("ambiguous", "precision cap")
    if proof is not None and open_ended and float(proof.t_end) < predictable:
        predictable, limit = float(proof.t_end), f"nothing later is certified: {proof.ending}"

    def play(step: float | None, instant: float | None = None) -> Result:
        """Run the scene with a step [s], None for the engine's own, until an instant."""
        if instant is None and run is not None:
            return _finished(run(step))
        return _finished(run_with_step(engine, _until(scene, instant), step))

    true = events_in(events_of(known.result))
    try:
        runs = [play(step) for step in (None, *steps[1:])]
        shared = _shared_collisions(true, runs, predictable)
        if shared is not None:
            return _by_times(found, engine, known, steps, shared)
        runs, instant = _compared(play, (None, *steps[1:]), runs, known, predictable)
        truth = known.positions(instant)
        differences = [largest_distance(one.rest_positions[:, :2], truth) for one in runs]
        varies = min(differences) < VARIES * max(differences)
        if steps and varies and not shrinks(differences):
            # The delay with which a step sees a contact is almost random, so a fourth run decides.
            steps = shorter_steps(engine, RUNGS + 1)
            once_more = play(steps[-1], instant)
            before = [one for one in true if instant is None or one.t <= instant]
            shared = _shared_collisions(before, [*runs, once_more], math.inf)
            if shared is not None:
                return _by_times(found, engine, known, steps, shared)
            differences.append(largest_distance(once_more.rest_positions[:, :2], truth))
    except NotComparedError as error:
        return replace(found, reason=str(error))
    if instant is not None:
        found = replace(found, instant=instant, until=limit)
    found = replace(
        found,
        difference=differences[0],
        ladder=tuple(map(Rung, steps, differences)),
        with_exact_steps=_with_exact_steps(engine, known, instant),
    )
    t = known.result.rest_time if instant is None else instant
    size = float(np.max(growth.sizes([t])))
    rounding = 0.0
    if math.isfinite(size):
        taken = t / steps[0] if steps else 0.0
        rounding = ROUNDINGS * UNIT_ROUNDOFF * size * (1.0 + taken)
        found = replace(found, rounding=rounding)
    if differences[0] <= max(rounding, NEGLIGIBLE):
        exact = instant is None and differences[0] <= rounding
        return replace(found, outcome="rounding" if exact else "agrees")
    return replace(found, outcome="step" if shrinks(differences) else "model")


@dataclass(frozen=True)
class _Shared:
    """The collisions that all runs share with the reference before collisions differ.

    `wrong_from` [s]: when the first wrong collision of each run is; inf if it has none.
    `late` [s]: largest error of the time of a shared collision, run by run.
    """

    count: int
    wrong_from: tuple[float, ...]
    late: tuple[float, ...]


def _shared_collisions(
    true: Sequence[Event], runs: Sequence[Result], predictable: float
) -> _Shared | None:
    """Return the collisions that all runs share; None if none is wrong within what's predictable.

    `true`: the collisions of the reference.
    `predictable` [s]: nothing is compared past it.
    """
    agreements = [compare_logs(true, events_in(events_of(run))) for run in runs]
    wrong = tuple(one.parting.t if one.parting else math.inf for one in agreements)
    if min(wrong) >= predictable:
        return None
    found: list[dict[Event, float]] = []
    for one in agreements:
        pairs = [(a, b.t - a.t) for a, b in one.before if a.t <= predictable]
        found.append(dict(pairs))
    common = set(found[0]).intersection(*found[1:])
    late = tuple(max((abs(times[one]) for one in common), default=math.nan) for times in found)
    return _Shared(len(common), wrong, late)


def _by_times(
    found: Attribution,
    engine: ReferenceEngine,
    known: KnownShot,
    steps: Sequence[float],
    shared: _Shared,
) -> Attribution:
    """Attribute a difference whose collisions differ, by the times of the shared collisions."""
    late = shared.late if shared.count else (None,) * len(shared.late)
    first_wrong = [t if math.isfinite(t) else None for t in shared.wrong_from]
    found = replace(
        found,
        instant=min(shared.wrong_from),
        until="collisions differ from then on",
        late=late[0],
        shared=shared.count,
        ladder=tuple(
            Rung(step, None, by, t) for step, by, t in zip(steps, late, first_wrong, strict=False)
        ),
        with_exact_steps=_with_exact_steps(engine, known, None),
    )
    if not steps:
        return replace(found, outcome="model")
    separated = shared.count > 0 and shared.late[0] > INSTANT and shrinks(shared.late)
    return replace(found, outcome="step" if separated else "unseparated")


def largest_distance(a: FloatArray, b: FloatArray) -> float:
    """Return the largest distance of a ball between two states (n, 2) [m]."""
    return float(np.max(np.hypot(*(a - b).T)))


def _compared(
    play: Callable[[float | None, float | None], Result],
    steps: Sequence[float | None],
    runs: list[Result],
    known: KnownShot,
    predictable: float,
) -> tuple[list[Result], float | None]:
    """Run an engine to the last instant up to which all runs can be compared; None: to the end.

    `play`: runs the scene with a step [s], None for the engine's own, until an instant.
    `runs`: with these steps, to the end; no wrong collision comes before `predictable` [s].

    Raises `NotComparedError` if there is no such instant, or a run stops early.
    """
    true, instant = events_in(events_of(known.result)), None
    for _ in range(ATTEMPTS):
        logs = [events_in(events_of(run)) for run in runs]
        before = [one for one in true if instant is None or one.t <= instant]
        agreed = agreed_instant(before, logs, predictable if instant is None else math.inf)
        if agreed is None:
            return runs, instant
        if agreed < EARLIEST:
            break
        instant = agreed
        runs = [play(step, instant) for step in steps]
    raise NotComparedError(
        f"engine `{runs[0].engine}` and the reference have no time at which they could be compared"
    )


def _until(scene: Scene, instant: float | None) -> Scene:
    return scene if instant is None else scene.model_copy(update={"t_max": instant})


def _finished(result: Result) -> Result:
    """Return a run that is complete.

    Raises `NotComparedError` if it isn't.
    """
    if not result.status.complete:
        raise NotComparedError(
            f'engine `{result.engine}` stopped early in scene "{result.scene.name}": '
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
        result = _finished(run_with_step(exact, _until(known.scene, instant), None))
    except (NotComparedError, ValidationError):
        return None  # no better way to play it, or none with its other settings
    if instant is None:
        true = events_in(events_of(known.result))
        if compare_logs(true, events_in(events_of(result))).parting is not None:
            return None  # the ends of two shots whose collisions differ aren't compared
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
