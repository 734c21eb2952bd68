"""The cause of an engine's error: its time step, its model, or rounding.

    >>> attribute(scene, make_engine("pymunk")).outcome
    'step'

The engine simulates the shot with its own time step and with two shorter ones. An error that
shrinks with the step is caused by the step. An error that stays is caused by the model: missing or
different physics. If every run has the collisions of the reference, the errors are distances of the
balls at the end. If collisions differ, the errors are time errors of the collisions that all runs
share.
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
from ghostball.validation.checks.requirements import approximations_of
from ghostball.validation.grading.event_logs import Agreement, Event, compare_logs, events_in
from ghostball.validation.grading.horizon import growth_along, horizon
from ghostball.validation.grading.tolerances import ROUNDINGS, UNIT_ROUNDOFF
from ghostball.validation.runs.sampling import events_of
from ghostball.validation.runs.time_steps import (
    run_with_step,
    shorter_steps,
    shrinks,
    with_setting,
)
from ghostball.validation.truth.certificates import certificate_of
from ghostball.validation.truth.known_shot import KnownBy, KnownShot, known_shot

Outcome = Literal["step", "model", "rounding", "agrees", "unseparated", "not compared"]
"""The main cause of an error.

"rounding": every collision is right, and the balls end where rounding allows. "agrees": the run
matches the reference as far as the two can be compared. "unseparated": collisions differ, and the
times of the shared ones don't say whether the step or the model is the cause.
"""

RUNGS: Final = 3
"""Number of time steps for each shot; if they contradict each other, a fourth step decides."""

LARGEST_VARIATION: Final = 0.75
"""Largest relative change, from step to step, of an error that the model alone causes."""

ATTEMPTS: Final = 8
"""Number of attempts at an earlier time: a new run may have an even earlier first difference."""

EARLIEST: Final = 1e-6
"""Times before this count as the start [s]."""

NEGLIGIBLE: Final = 1e-9
"""Position errors below this aren't explained [m]: engines are expected to be accurate to
nanometres.
"""

NEGLIGIBLE_TIME: Final = 1e-9
"""Time errors of collisions below this aren't explained [s]: it is a nanometre at 1 m/s."""

PREDICTABLE: Final = 1e-6
"""Displacement by rounding above which a shot counts as unpredictable [m].

It is a thousandth of the error of the best time-stepping engine, so that chaos isn't attributed to
the engine.
"""


@dataclass(frozen=True)
class Rung:
    """A run with one time step.

    `step` [s].
    `difference` [m]: largest distance of a ball from the reference; None if collisions differ.
    `late` [s]: largest time error of a collision that all runs share; None if there is none.
    `wrong_from` [s]: time of its first wrong collision; None if there is none.
    """

    step: float
    difference: float | None
    late: float | None = None
    wrong_from: float | None = None


@dataclass(frozen=True)
class Attribution:
    """The cause of an engine's error in one scene.

    `scene`, `label`, `engine`: as in a `CaseRecord`.
    `truth`: the source of the reference.
    `reason`: why nothing could be compared; else "".
    `instant` [s]: time at which balls were compared, or at which collisions first differ; None: the
        end.
    `until`: why the comparison ends there; else "".
    `difference` [m]: largest distance of a ball from the reference; None if collisions differ.
    `late` [s]: largest time error of a collision that all runs share.
    `shared`: number of collisions that all runs share, if collisions differ.
    `rounding` [m]: largest displacement by rounding; None if there is no derivative.
    `approximations`: features of the scene that the engine supports only approximately.
    `ladder`: one run for each time step, longest first; empty for an engine without a time step.
    `with_exact_steps` [m]: the difference if time steps end exactly at contacts; None if the engine
        can't do this.
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
    """Runs that can't be compared with the reference at any time."""


def attribute(
    scene: Scene,
    engine: ReferenceEngine,
    *,
    label: str = "",
    known: KnownShot | None = None,
    run: Callable[[float | None], Result] | None = None,
) -> Attribution:
    """Return the cause of an engine's error.

    `label`: the engine with its settings, as the user wrote it; default: its name.
    `known`: the reference, if the caller has it.
    `run`: returns the run of the scene with a time step [s], or None for the engine's own; for
        callers that store such runs. The runs need their events.

    Raises `UnsupportedSceneError` if the engine, or the reference, lacks a feature of the scene;
    `GhostballError` if the reference can't be computed.

    If every run has the collisions of the reference and the shot is predictable to its end, final
    positions are compared. If the shot is predictable only up to some time, the engine simulates it
    again up to that time. If collisions differ before that time, times of collisions are compared.
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
    certificate, _ = certificate_of(scene)
    growth = growth_along(scene, certificate, known.result)
    predictable = horizon(growth, PREDICTABLE, ROUNDINGS * UNIT_ROUNDOFF)
    limit = "after that, rounding moves a ball by more than a micrometre"
    open_ended = certificate is not None and certificate.ending in ("ambiguous", "precision cap")
    if certificate is not None and open_ended and float(certificate.t_end) < predictable:
        predictable, limit = (
            float(certificate.t_end),
            f"nothing later is certified: {certificate.ending}",
        )

    def play(step: float | None, instant: float | None = None) -> Result:
        """Run the scene up to a time, with a time step [s]; None is the engine's own step."""
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
        varies = min(differences) < LARGEST_VARIATION * max(differences)
        if steps and varies and not shrinks(differences):
            # The delay with which a contact is detected is almost random, so a fourth run decides.
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

    `wrong_from` [s]: time of the first wrong collision of each run; inf if there is none.
    `late` [s]: largest time error of a shared collision, for each run.
    """

    count: int
    wrong_from: tuple[float, ...]
    late: tuple[float, ...]


def _shared_collisions(
    true: Sequence[Event], runs: Sequence[Result], predictable: float
) -> _Shared | None:
    """Return the collisions that all runs share; None if no run has a wrong one by `predictable`.

    `true`: the collisions of the reference.
    `predictable` [s]: later events aren't compared.
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
    """Attribute an error with different collisions, by the times of the shared collisions."""
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
    separated = shared.count > 0 and shared.late[0] > NEGLIGIBLE_TIME and shrinks(shared.late)
    return replace(found, outcome="step" if separated else "unseparated")


def largest_distance(a: FloatArray, b: FloatArray) -> float:
    """Return the largest distance between the positions of a ball in two states (n, 2) [m]."""
    return float(np.max(np.hypot(*(a - b).T)))


def _compared(
    play: Callable[[float | None, float | None], Result],
    steps: Sequence[float | None],
    runs: list[Result],
    known: KnownShot,
    predictable: float,
) -> tuple[list[Result], float | None]:
    """Return runs up to the last time at which all can be compared, and that time; None: the end.

    `play`: runs the scene up to a time, with a time step [s]; None is the engine's own step.
    `runs`: with these steps, to the end; no wrong collision comes before `predictable` [s].

    Raises `NotComparedError` if there is no such time, or if a run stops early.
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
    """Return a run if it is complete.

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
    """Return the difference if steps end at contacts; None if the engine can't do this."""
    if getattr(engine.settings, "contact_steps", None) != "fixed":
        return None
    try:
        exact = with_setting(engine, "contact_steps", "exact")
        result = _finished(run_with_step(exact, _until(known.scene, instant), None))
    except (NotComparedError, ValidationError):
        return None  # unsupported, or incompatible with its other settings
    if instant is None:
        true = events_in(events_of(known.result))
        if compare_logs(true, events_in(events_of(result))).parting is not None:
            return None  # final states aren't compared if collisions differ
    return largest_distance(result.rest_positions[:, :2], known.positions(instant))


def agreed_instant(
    true: Sequence[Event], runs: Sequence[Sequence[Event]], end: float
) -> float | None:
    """Return the last time up to which logs agree with the reference; None: to the end.

    `end` [s]: end of the comparison; infinite: the end of the runs.

    The time is in the middle of the last interval in which no run is between its own time and the
    reference time of a collision: otherwise, a detection delay would count as an error.
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
