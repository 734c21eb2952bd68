"""One engine, be it anyone's, held against the suite: what is asked of it, and what came of that.

Asked are the limits that name the engine, as in `ghostball validate`: those of the scene, then
those of a file that holds for all scenes, then the common ones. In a scene whose own limits don't
name it, it is also asked what no engine may break, on other metrics; see `asked_of_any`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from ghostball.engine import Scene
from ghostball.reference_adapters import ReferenceEngine, engine_names, make_engine
from ghostball.reference_adapters.base import resolution_of, stated_error
from ghostball.validation.checks.accuracy import THROUGH
from ghostball.validation.checks.criteria import Criteria, common_criteria
from ghostball.validation.checks.criterion import Criterion, Selector, StepRule
from ghostball.validation.checks.metric_table import METRICS
from ghostball.validation.checks.metrics import conserves_energy, past_horizon
from ghostball.validation.checks.step_limits import STEP_METRICS
from ghostball.validation.results.records import (
    COMPLETE_STATUSES,
    INDEPENDENT,
    CaseRecord,
    Check,
    Motion,
)
from ghostball.validation.suite.case import (
    Case,
    TruthFailure,
    approximations_of,
    plain_settings,
    run_case,
    with_step_limits,
)
from ghostball.validation.suite.suite import truth_or_failure

COMPLETES = "completes"
"""What is asked beside the metrics: that a run ends by itself, with finite numbers all along."""

ENERGY_NOISE = 1e-6
"""Rise of energy, over the initial one, that is left to a solver, as in the shipped scenes.

A wrong sign or a wrong mass is beyond it by orders of magnitude.
"""

EXACT_ENERGY_NOISE = 5e-13
"""The same of an engine that claims rounding alone: an impact rounds the energy by some 2^-53, and
this is what four thousand of them come to, all the same way.
"""

EXACT_OVERLAP = 1e-12
"""Overlap [m] of balls whose engine claims rounding alone: a thousand roundings of a table."""

Outcome = Literal["passed", "failed", "skipped"]


@dataclass(frozen=True, eq=False)
class EngineUnderTest:
    """An engine with its settings.

    Attributes
    ----------
    spec : str
        As asked for: `NAME` or `MODULE:CLASS`, and settings after another colon.
    make : callable
        Makes one like it.
    judged_as : EngineUnderTest or None
        Another engine, whose limits it is held against; None: its own.
    """

    spec: str
    make: Callable[[], ReferenceEngine]
    judged_as: EngineUnderTest | None = None

    @property
    def limited(self) -> EngineUnderTest:
        """The engine whose limits hold."""
        return self if self.judged_as is None else self.judged_as


@dataclass(frozen=True)
class Asked:
    """What is asked of an engine in a scene.

    Attributes
    ----------
    stated : tuple of Criterion
        What names the engine.
    of_any : tuple of Criterion
        What no engine may break, on other metrics.
    rule : StepRule or None
        By which limits are computed from the engine's step, on other metrics, as the scene runs.
    """

    stated: tuple[Criterion, ...] = ()
    of_any: tuple[Criterion, ...] = ()
    rule: StepRule | None = None

    @property
    def metrics(self) -> tuple[str, ...]:
        """Names of what is asked, `COMPLETES` first, then metrics in the order of `METRICS`."""
        limited = {criterion.metric for criterion in (*self.stated, *self.of_any)}
        if self.rule is not None:
            limited |= STEP_METRICS
        return (COMPLETES, *(name for name in METRICS if name in limited))


@dataclass(frozen=True)
class Finding:
    """What came of one thing that was asked: `words` is one sentence, "" where it passed."""

    outcome: Outcome
    words: str = ""
    checks: tuple[Check, ...] = ()


@dataclass(frozen=True, eq=False)
class SceneRun:
    """A scene that was run on an engine.

    Attributes
    ----------
    record : CaseRecord
    asked : Asked
    motion : Motion or None
        None where the engine did not come to its end.
    not_finite : str
        The first number of the motion that isn't finite, and where; "" where all are.
    """

    record: CaseRecord
    asked: Asked
    motion: Motion | None = None
    not_finite: str = ""

    def finding(self, metric: str) -> Finding:
        """Return what came of `COMPLETES`, or of all limits on a metric."""
        record = self.record
        if record.outcome == "not-representable":
            return Finding("skipped", f"{record.scene}: not representable: {record.reason}")
        if record.outcome != "ran":
            return Finding("failed", f"{record.engine} failed: {record.reason}")
        if metric == COMPLETES:
            return self._completion()
        criteria = [c for c in (*self.asked.stated, *self.asked.of_any) if c.metric == metric]
        if unpredictable := self._past_horizon(criteria):
            return Finding("skipped", f"{record.scene}: {unpredictable}")
        checks = tuple(check for check in record.checks if check.metric == metric)
        if not checks:
            note = record.notes.get(metric) or (
                _NOT_INDEPENDENT if criteria else "no limit on this follows from the engine's step"
            )
            return Finding("skipped", f"{record.scene}: {note}")
        broken = tuple(check for check in checks if check.passed is False)
        if broken:
            return Finding("failed", "; ".join(check.sentence for check in broken), broken)
        if all(check.passed is None for check in checks):
            return Finding("skipped", f"{record.scene}: {checks[0].note}", checks)
        return Finding("passed", checks=checks)

    def _completion(self) -> Finding:
        record = self.record
        if record.status not in COMPLETE_STATUSES:
            why = f": {record.reason}" if record.reason else ""
            return Finding(
                "failed", f"the run must end by itself, it ended early: {record.status}{why}"
            )
        if self.not_finite:
            return Finding("failed", f"the motion must be finite, got {self.not_finite}")
        return Finding("passed")

    def _past_horizon(self, criteria: list[Criterion]) -> str:
        """Say that nothing can be expected of how the shot ends, where that is so; else ""."""
        horizon = self.record.horizon
        of_the_end = any(METRICS[criterion.metric].to_the_end for criterion in criteria)
        anyway = any(criterion.past_horizon for criterion in criteria)
        return past_horizon(horizon) if horizon is not None and of_the_end and not anyway else ""


_NOT_INDEPENDENT = (
    "no truth of this scene is independent of the engine `ghostball`: its counts prove nothing"
)


def engine_under_test(spec: str, judged_as: str | None = None) -> EngineUnderTest:
    """Find an engine by its name, or by where its class is, and make sure that it can be made.

    Parameters
    ----------
    spec : str
        `NAME` of an installed engine, or `MODULE:CLASS`; either may be followed by
        `:key=value,...`.
    judged_as : str, optional
        Another engine, likewise, whose limits it is held against.

    Raises
    ------
    EngineError
        Where there is none such, or it can't run here.
    """
    make_engine(spec)
    other = None if judged_as is None else engine_under_test(judged_as)
    return EngineUnderTest(spec, lambda: make_engine(spec), other)


def asked_of(
    engine: EngineUnderTest,
    scene: Scene,
    own: Criteria,
    for_all: Criteria | None = None,
) -> Asked:
    """Return what is asked of an engine in a scene.

    Parameters
    ----------
    engine : EngineUnderTest
    scene : Scene
    own : Criteria
        Of the scene.
    for_all : Criteria, optional
        For all scenes; where both limit a metric, the scene's hold.

    Raises
    ------
    CriteriaError
        Where criteria contradict each other.
    """
    judged = engine.limited.make()
    settings = plain_settings(judged)
    # Limits may be written for the engine itself also where it is judged as another one.
    names = _names(engine, judged.name, settings)
    stated: tuple[Criterion, ...] = ()
    for name, values in names:
        for criteria in (own, for_all, common_criteria()):
            limited = {criterion.metric for criterion in stated}
            found = () if criteria is None else criteria.applying_to(name, values)
            stated += tuple(one for one in found if one.metric not in limited)
    wider = (common_criteria(),) if for_all is None else (for_all, common_criteria())
    rule = own.step_rule(judged.name, settings, *wider)
    if rule is not None or any(own.applying_to(name, values) for name, values in names):
        return Asked(stated, rule=rule)  # whoever wrote them knew what to ask here, and what not
    limited = {criterion.metric for criterion in stated}
    others = asked_of_any(engine.make(), scene)
    return Asked(stated, tuple(one for one in others if one.metric not in limited))


def asked_of_any(engine: ReferenceEngine, scene: Scene) -> tuple[Criterion, ...]:
    """Return what no engine may break in a scene, besides that its run completes.

    Energy never rises, and holds where nothing takes it. Balls overlap by no more than the engine
    states: each of two may be off by its `resolution` when they collide. Of one that states
    nothing, nothing is known: it must not let balls through each other. An engine that claims to
    be exact here, for it states a `resolution` of 0 and no feature that is approximate, finds
    every collision that there is and no other; counts are judged where truth is independent of our
    engine.
    """
    stated = resolution_of(engine, scene)
    resolution = stated_error(stated)
    exact = stated is not None and resolution == 0.0 and not approximations_of(engine, scene)
    limit = _Limits(Selector(engine=engine.name))
    noise, whose = (
        (EXACT_ENERGY_NOISE, "four thousand roundings")
        if exact
        else (ENERGY_NOISE, "a solver's noise")
    )
    asked = [
        limit.at_most(
            "energy_rise",
            noise,
            f"Cloth, cushions and impacts only take energy; {noise:g} is left to {whose}.",
        )
    ]
    if conserves_energy(scene):
        asked.append(
            limit.at_most(
                "energy_drift",
                noise,
                f"Nothing in this scene takes energy; {noise:g} is left to {whose}.",
            )
        )
    if len(scene.balls) > 1 and stated is None:
        why = (
            f"Engine `{engine.name}` states no `resolution`, so nothing is known of how exact it "
            "is; but no ball goes through another."
        )
        asked.append(limit.at_most("overlap_max", THROUGH * float(np.min(scene.radii)), why))
    elif len(scene.balls) > 1:
        states = (
            f"states that a ball is off by at most {resolution:.3g} m when it collides "
            "(`resolution`), so two overlap by at most twice that."
            if resolution > 0.0
            else "states a `resolution` of 0: balls that collide touch, but for rounding."
        )
        why = f"Engine `{engine.name}` {states}"
        asked.append(limit.at_most("overlap_max", 2.0 * resolution + EXACT_OVERLAP, why))
    if exact:
        claim = (
            f"Engine `{engine.name}` claims to be exact here: it states a `resolution` of 0 and no "
            "approximation."
        )
        asked += [
            limit.none(metric, claim)
            for metric in (
                "ball_ball_count_error",
                "ball_cushion_count_error",
                "events_missing",
                "events_invented",
            )
        ]
    return tuple(asked)


def run_scene(
    engine: EngineUnderTest,
    scene: Scene,
    own: Criteria,
    asked: Asked,
    make: Callable[[], ReferenceEngine] | None = None,
) -> SceneRun:
    """Run a scene on an engine; whatever goes wrong becomes part of the record.

    Parameters
    ----------
    engine : EngineUnderTest
    scene : Scene
    own : Criteria
        Of the scene.
    asked : Asked
    make : callable, optional
        Makes the engine that runs, such as one in another process; `engine.make` unless told.

    Raises
    ------
    KeyboardInterrupt
    """
    truth = truth_or_failure(scene, own)
    if not isinstance(truth, TruthFailure) and truth.kind not in INDEPENDENT:
        asked = replace(
            asked,
            of_any=tuple(one for one in asked.of_any if METRICS[one.metric].compares != "events"),
        )
    case = Case(scene, engine.spec, truth, (*asked.stated, *asked.of_any), rule=asked.rule)
    case = with_step_limits(case, engine.limited.make())
    record, motion = run_case(case, lambda _: (make or engine.make)())
    return SceneRun(record, asked, motion, "" if motion is None else _not_finite(motion))


def check_names(criteria: Criteria, engine: EngineUnderTest, source: str) -> None:
    """Make sure that criteria name engines that there are, this one included.

    Raises
    ------
    CriteriaError
    """
    criteria.check_engines(dict.fromkeys((*engine_names(), engine.make().name)), source)


class _Limits:
    """Makes criteria that cover one engine."""

    def __init__(self, selector: Selector) -> None:
        self._engines = (selector,)

    def at_most(self, metric: str, limit: float, reason: str) -> Criterion:
        return Criterion(
            engines=self._engines, metric=metric, at_most=limit, if_measured=True, reason=reason
        )

    def none(self, metric: str, reason: str) -> Criterion:
        return Criterion(
            engines=self._engines, metric=metric, equals=0, if_measured=True, reason=reason
        )


def _names(
    engine: EngineUnderTest, judged: str, settings: Mapping[str, Any]
) -> list[tuple[str, Mapping[str, Any]]]:
    own = engine.make()
    mine = (own.name, plain_settings(own))
    return [mine] if engine.judged_as is None else [mine, (judged, settings)]


def _not_finite(motion: Motion) -> str:
    arrays = {
        "position": motion.positions,
        "velocity": motion.velocities,
        "angular velocity": motion.angular_velocities,
    }
    for what, values in arrays.items():
        where = np.argwhere(~np.isfinite(values))
        if len(where):
            k, ball, axis = where[0]
            value, t = values[k, ball, axis], motion.times[k]
            return f"{value} for the {what} of ball {ball} at t = {t:.6g} s"
    return ""
