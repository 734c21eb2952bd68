"""Divide the difference of one engine in one scene: model, discretisation, rounding."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import GhostballError, Scene
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.checks.law import approximations_of
from ghostball.validation.diagnose.attribution._backward import (
    NoCueBallError,
    NotCertifiedError,
    backward_error,
)
from ghostball.validation.diagnose.attribution._runs import (
    ULPS,
    Played,
    StoppedEarlyError,
    agreed_instant,
    ladder_of,
    play,
    play_ulps,
)
from ghostball.validation.diagnose.attribution._zero_step import (
    ZeroStep,
    largest_distance,
    zero_step_of,
)
from ghostball.validation.diagnose.attribution.attribution_record import Attribution, Better, Part
from ghostball.validation.grading.event_logs import events_in
from ghostball.validation.grading.horizon import growth_along, horizon
from ghostball.validation.grading.tolerances import UNIT_ROUNDOFF
from ghostball.validation.runs.sampling import events_of
from ghostball.validation.runs.steps import step_setting, with_setting, with_step
from ghostball.validation.truth.known_shot import KnownShot, known_shot
from ghostball.validation.truth.proof import proof_of

FloatArray = NDArray[np.float64]

ATTEMPTS = 8
"""How often an earlier instant is tried, because a finer run parts before the last one."""

EARLIEST = 1e-6
"""Instants before this are the start [s]: nothing has happened."""

ROUNDINGS = 32.0
"""What an ulp of the input does, times this, is a difference that says nothing."""

MOST_UNCERTAIN = 0.5
"""Largest uncertainty of a part that is still given, as a part of the difference."""

NO_MATTER = 0.01
"""Part of the difference below which it doesn't matter what the step changes."""

PREDICTABLE = 1e-6
"""How far an ulp of the input may move a ball before the shot counts as unpredictable [m].

A thousandth of what the best stepping engine is off, so that chaos is told from its errors.
"""


class NoInstantError(GhostballError):
    """Runs that agree with the truth at no instant, so that nothing can be compared."""


@dataclass(frozen=True, eq=False)
class _Ladder:
    """All runs of one engine that are compared at one instant.

    `base` is the engine as it was asked for, `runs` are those at shorter steps, none where it has
    no step; `shot` is the scene up to `instant`, which is None at the end; `until` says why not.
    """

    base: Played
    steps: list[float]
    runs: list[Played]
    ulps: list[Played]
    shot: Scene
    instant: float | None
    until: str

    def limit(self) -> ZeroStep:
        """Return what it says of zero step."""
        return zero_step_of(self.steps, [one.positions for one in (self.base, *self.runs)])


def attribute(
    scene: Scene,
    engine: ReferenceEngine,
    *,
    label: str = "",
    known: KnownShot | None = None,
) -> Attribution:
    """Say where the difference of an engine from the truth comes from.

    Parameters
    ----------
    scene : Scene
    engine : ReferenceEngine
    label : str
        The engine as asked for; its name where it is left out.
    known : KnownShot, optional
        The true shot, where the caller has it.

    Returns
    -------
    Attribution

    Raises
    ------
    UnsupportedSceneError
        Where the engine, or the truth, lacks a feature of the scene.
    GhostballError
        Where the truth comes to no end.

    Notes
    -----
    Balls are compared where they end, as long as every run has the collisions of the truth, ball
    by ball, and the shot is predictable; else at the last instant of which both hold, to which the
    engine is run anew. The discretisation is the way from the engine's own run to the limit at zero
    step, the model's part the way from there to the truth, rounding what an ulp of the input does.
    The limit and its uncertainty are those of `zero_step_of`. Neither part is given where the
    uncertainty is over half of the difference, or where errors don't fall with the step.
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
    try:
        ladder = _climb(scene, engine, known)
    except (StoppedEarlyError, NoInstantError) as error:
        return replace(found, reason=str(error))
    truth, outcome = known.positions(ladder.instant), ladder.base.positions
    rounding = max((largest_distance(one.positions, outcome) for one in ladder.ulps), default=None)
    difference = largest_distance(outcome, truth)
    found = replace(
        found,
        instant=ladder.instant,
        until=ladder.until,
        difference=difference,
        rounding=rounding,
    )
    if ladder.instant is not None and rounding is not None and difference <= ROUNDINGS * rounding:
        return replace(found, reason=_nothing_to_divide(known, ladder.instant))
    if ladder.runs:
        found = replace(
            found,
            step=ladder.base.step,
            finest=ladder.steps[-1],
            runs=1 + len(ladder.runs),
            better=tuple(_better(engine, ladder, truth, difference)),
        )
    return _with_backward(_divided(found, ladder, truth), known, outcome, ladder.instant)


def _nothing_to_divide(known: KnownShot, instant: float) -> str:
    """Say why a difference that is but rounding isn't divided: the shot parts before it shows."""
    assert known.result.events is not None
    early = not np.any(known.result.events["t"] <= instant)
    until = "an instant before the first event" if early else f"t = {instant:.6g} s"
    return (
        f"the runs can be compared up to {until}, where nothing differs by more than rounding: "
        "what they differ by comes with the collisions after it"
    )


def _divided(found: Attribution, ladder: _Ladder, truth: FloatArray) -> Attribution:
    """Divide a difference, as far as the ladder says how."""
    outcome, rounding, whole = ladder.base.positions, found.rounding or 0.0, found.difference
    assert whole is not None
    if not ladder.runs:
        model = _part(outcome - truth, outcome - truth, rounding)
        return replace(found, outcome="no step", model=model)
    limit = ladder.limit()
    uncertainty = limit.uncertainty + rounding
    if uncertainty > MOST_UNCERTAIN * whole:
        why = (
            f"steps down to {ladder.steps[-1]:.2g} s leave open by {uncertainty:.2g} m where the "
            "balls would be at zero step: that is more than half of the difference"
        )
        return replace(found, outcome="not told", reason=why)
    if not limit.falls and limit.spread > NO_MATTER * whole:
        why = (
            f"errors don't fall with the step: over the step, they are {limit.growth:.2g} times "
            f"larger in the finer half of {len(ladder.steps)} runs"
        )
        return replace(found, outcome="not told", reason=why)
    difference = outcome - truth
    return replace(
        found,
        outcome="attributed",
        model=_part(limit.positions - truth, difference, uncertainty),
        discretisation=_part(outcome - limit.positions, difference, uncertainty),
    )


def _better(
    engine: ReferenceEngine, ladder: _Ladder, truth: FloatArray, difference: float
) -> Iterator[Better]:
    """Yield how else the engine plays the shot, where that is nearer to the truth."""
    name = step_setting(engine)
    assert name is not None  # of an engine with a ladder
    finest = largest_distance(ladder.runs[-1].positions, truth)
    if finest < difference:
        yield Better(name, ladder.steps[-1], finest)
    if getattr(engine.settings, "mode", None) == "native":
        try:
            landed = play(with_setting(engine, "mode", "landed"), ladder.shot)
        except StoppedEarlyError:
            return  # no better way to play it
        nearer = largest_distance(landed.positions, truth)
        if nearer < difference:
            yield Better("mode", "landed", nearer)


def _part(part: FloatArray, difference: FloatArray, uncertainty: float) -> Part:
    whole = float(np.sum(difference**2))
    share = float(np.sum(part * difference)) / whole if whole > 0.0 else 0.0
    return Part(largest_distance(part, np.zeros_like(part)), uncertainty, share)


def _with_backward(
    found: Attribution, known: KnownShot, outcome: FloatArray, instant: float | None
) -> Attribution:
    try:
        return replace(found, backward=backward_error(known, outcome, instant))
    except (NoCueBallError, NotCertifiedError) as error:
        return replace(found, no_backward=str(error))


def _climb(scene: Scene, engine: ReferenceEngine, known: KnownShot) -> _Ladder:
    """Run a ladder to the last instant up to which every run of it agrees with the truth.

    Raises
    ------
    StoppedEarlyError
        Where a run doesn't come to its end.
    NoInstantError
        Where there is no such instant.
    """
    true = events_in(events_of(known.result))
    growth = growth_along(scene, proof_of(scene)[0], known.result)
    predictable = horizon(growth, PREDICTABLE, 2.0 * UNIT_ROUNDOFF)
    instant: float | None = None
    until = ""
    for attempt in range(ATTEMPTS):
        shot = scene if instant is None else scene.model_copy(update={"t_max": instant})
        log = [one for one in true if instant is None or one.t <= instant]
        end = predictable if instant is None else math.inf
        base = play(engine, shot)
        agreed = agreed_instant(log, [base.collisions], end)
        steps: list[float] = []
        if step_setting(engine) is not None:
            duration = known.result.rest_time if instant is None else instant
            steps = ladder_of(base.step, duration, shot.t_max)
        runs: list[Played] = []
        for step in steps[1:]:
            # The engine's own run parts first as a rule: at first that is enough.
            if agreed is not None and attempt == 0:
                break
            runs.append(play(with_step(engine, step), shot))
            logs = [one.collisions for one in (base, *runs)]
            agreed = agreed_instant(log, logs, end)
        if agreed is None:
            return _Ladder(base, steps, runs, play_ulps(engine, shot, ULPS), shot, instant, until)
        if agreed < EARLIEST:
            raise NoInstantError(
                f"engine `{engine.name}` and the truth part before any instant at which they "
                "could be compared"
            )
        until = _why(agreed, predictable)
        instant = agreed
    raise NoInstantError(
        f"each finer run of engine `{engine.name}` parts from the truth before the coarser ones: "
        f"after {ATTEMPTS} attempts there is no instant at which to compare them"
    )


def _why(instant: float, predictable: float) -> str:
    if instant < predictable:
        return "the collisions of some run of the ladder are others from then on"
    return "past it, the last digit of the input moves a ball by more than a micrometre"
