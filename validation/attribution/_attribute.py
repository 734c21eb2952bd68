"""Divide the difference of one engine in one scene: model, discretisation, rounding."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from engine import GhostballError, Scene
from reference_adapters import ReferenceEngine
from validation.attribution._backward import NoCueBallError, NotCertifiedError, backward_error
from validation.attribution._extrapolation import (
    Extrapolation,
    extrapolate,
    largest_distance,
)
from validation.attribution._horizon import horizon
from validation.attribution._runs import (
    PLANS,
    ULPS,
    Plan,
    Played,
    StoppedEarlyError,
    agreed_instant,
    plan_for,
    play,
    play_level,
    play_ulps,
)
from validation.attribution.records import Attribution, Part
from validation.case import approximations_of
from validation.known_shot import KnownShot, known_shot
from validation.parting import collisions_in
from validation.sampling import events_of
from validation.steps import step_setting

FloatArray = NDArray[np.float64]

ATTEMPTS = 8
"""How often an earlier instant is tried, because a finer run parts before the last one."""

EARLIEST = 1e-6
"""Instants before this are the start [s]: nothing has happened."""


@dataclass(frozen=True, eq=False)
class _Ladder:
    """All runs of one engine that are compared at one instant.

    `base` is the engine as it was asked for; `instant` is None at the end; `until` says why not.
    """

    base: Played
    levels: list[list[Played]]
    ulps: list[Played]
    instant: float | None
    until: str

    def fit(self, known: KnownShot) -> Extrapolation:
        """Return what it says of zero step."""
        return extrapolate(
            [level[0].step for level in self.levels],
            [np.array([one.positions for one in level]) for level in self.levels],
            known.positions(self.instant),
        )


ROUNDINGS = 32.0
"""What an ulp of the input does, times this, is a difference that says nothing."""


class NoInstantError(GhostballError):
    """Runs that agree with the truth at no instant, so that nothing can be compared."""


def attribute(
    scene: Scene,
    engine: ReferenceEngine,
    *,
    label: str = "",
    known: KnownShot | None = None,
    plan: Plan | None = None,
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
    plan : Plan, optional
        How much is run; else as much as `plan_for` allows.

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
    engine is run anew. The discretisation is the way from the engine's own run to the limit of a
    ladder of halved steps, each from several start phases; the model's part the way from there to
    the truth, rounding what an ulp of the input does.
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
        ladder = _climb(scene, engine, known, plan)
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
        step=ladder.base.step or None,
        phases=tuple(len(level) for level in ladder.levels),
    )
    if ladder.instant is not None and rounding is not None and difference <= ROUNDINGS * rounding:
        return replace(found, reason=_nothing_to_divide(known, ladder.instant))
    return _with_backward(_divided(found, ladder, known), known, outcome, ladder.instant)


def _nothing_to_divide(known: KnownShot, instant: float) -> str:
    """Say why a difference that is but rounding isn't divided: the shot parts before it shows."""
    assert known.result.events is not None
    early = not np.any(known.result.events["t"] <= instant)
    until = "an instant before the first event" if early else f"t = {instant:.6g} s"
    return (
        f"the runs can be compared up to {until}, where nothing differs by more than rounding: "
        "what they differ by comes with the collisions after it"
    )


def _divided(found: Attribution, ladder: _Ladder, known: KnownShot) -> Attribution:
    """Divide a difference, as far as the ladder says how."""
    outcome, truth = ladder.base.positions, known.positions(ladder.instant)
    rounding = found.rounding or 0.0
    if not ladder.levels:
        model = _part(outcome - truth, outcome - truth, rounding)
        return replace(found, outcome="no step", model=model)
    fit = ladder.fit(known)
    found = replace(
        found,
        flat=fit.outcome == "flat",
        order=fit.order,
        order_low=fit.order_low,
        order_high=fit.order_high,
        order_used=fit.order_used,
    )
    if fit.outcome == "not converged":
        why = "the states don't go to a limit as the step goes to zero, as far as it was halved"
        return replace(found, outcome="not converged", reason=why)
    uncertainty = fit.uncertainty + rounding
    difference = outcome - truth
    return replace(
        found,
        outcome="attributed",
        model=_part(fit.limit - truth, difference, uncertainty),
        discretisation=_part(outcome - fit.limit, difference, uncertainty),
    )


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


def _climb(scene: Scene, engine: ReferenceEngine, known: KnownShot, plan: Plan | None) -> _Ladder:
    """Run the ladder: the shortest first, a longer one where it is affordable and says more.

    Errors are those of `_settle`.
    """
    predictable = horizon(scene, ULPS)
    short = PLANS[-1] if plan is None else plan
    ladder = _settle(scene, engine, known, short, predictable, None, "")
    if plan is not None or not ladder.levels or ladder.fit(known).outcome == "flat":
        return ladder
    duration = known.result.rest_time if ladder.instant is None else ladder.instant
    longer = plan_for(duration, ladder.base.step)
    if longer == short:
        return ladder
    return _settle(scene, engine, known, longer, predictable, ladder.instant, ladder.until)


def _settle(
    scene: Scene,
    engine: ReferenceEngine,
    known: KnownShot,
    plan: Plan,
    predictable: float,
    instant: float | None,
    until: str,
) -> _Ladder:
    """Run a ladder to the last instant up to which every run of it agrees with the truth.

    Raises
    ------
    StoppedEarlyError
        Where a run doesn't come to its end.
    NoInstantError
        Where there is no such instant.
    """
    true = collisions_in(events_of(known.result))
    phases = () if step_setting(engine) is None else plan.phases
    for attempt in range(ATTEMPTS):
        shot = scene if instant is None else scene.model_copy(update={"t_max": instant})
        log = [one for one in true if instant is None or one.t <= instant]
        end = predictable if instant is None else math.inf
        base = play(engine, shot)[0]
        logs = [base.collisions]
        levels: list[list[Played]] = []
        agreed = agreed_instant(log, logs, end)
        for level, count in enumerate(phases):
            # The coarsest level parts first as a rule and costs least: at first that is enough.
            if agreed is not None and attempt == 0:
                break
            others = play_level(engine, shot, base.step / 2**level, count, first=level > 0)
            levels.append(others if level else [base, *others])
            logs += [one.collisions for one in others]
            agreed = agreed_instant(log, logs, end)
        if agreed is None:
            return _Ladder(base, levels, play_ulps(engine, shot, ULPS), instant, until)
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
    return "past it, an ulp of the input moves a ball by more than a micrometre"
