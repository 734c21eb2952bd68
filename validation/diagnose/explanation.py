"""Explain how an engine's shot differs from the reference, and what causes the difference."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import cache, partial
from typing import Any, Final

import numpy as np

from ghostball.model import (
    OBSTACLE_KINDS,
    EngineFailedError,
    GhostballError,
    Result,
    Scene,
    Status,
    partner_name,
)
from ghostball.model.arrays import FloatArray
from ghostball.model.rounding import CONTACT_TOLERANCE
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.diagnose.attribution import NEGLIGIBLE_TIME, Attribution, attribute
from ghostball.validation.diagnose.contact_states import ContactFault, fault_at_contacts
from ghostball.validation.diagnose.margins import Margin, margins_of
from ghostball.validation.diagnose.self_check import contradiction_in
from ghostball.validation.diagnose.wrong_factor import Factor, wrong_factor
from ghostball.validation.grading.event_logs import (
    Agreement,
    Event,
    Parting,
    compare_logs,
    events_in,
)
from ghostball.validation.results.records import status_name
from ghostball.validation.runs.sampling import events_of
from ghostball.validation.runs.time_steps import run_with_step
from ghostball.validation.truth.known_shot import KnownShot, farthest, known_shot

SCHEMA: Final = 6
"""Version of `Explanation.to_dict`."""


SAMPLE_COUNT: Final = 401
"""Number of times at which the two motions are compared."""

VISIBLE_SHARE: Final = 0.01
"""Share of the largest distance above which a motion counts as different."""


class ExplanationError(GhostballError, ValueError):
    """A shot and an engine without anything to explain."""


@dataclass(frozen=True, eq=False)
class BallStates:
    """A ball at the first difference: (2,) each, in the reference and in the engine's run."""

    ball: str
    true_position: FloatArray
    true_velocity: FloatArray
    position: FloatArray
    velocity: FloatArray

    @property
    def distance(self) -> float:
        """Distance of the two centres [m]."""
        return float(np.hypot(*(self.position - self.true_position)))


@dataclass(frozen=True, eq=False)
class Explanation:
    """The first difference between a run and the reference, and its causes.

    `label`: the engine with its settings, as the user wrote it.
    `known`: the reference.
    `result`: the engine's run, with its motion.
    `agreement`: the collisions that both have, and the first difference.
    `margins`: the smallest first; empty without a difference.
    `states`: the balls of the first difference, at that time.
    `contradiction`: how the result contradicts itself, or "". If it does, no cause is computed.
    `attribution`: None if it wasn't requested.
    `fault`: the error at most contacts of a kind, with the shortest time step; None if there is
        none, or if a coefficient explains it.
    `factor`: the single coefficient that explains the motion with this time step; None if there is
        none, if it wasn't requested, or if the difference is caused by the time step.
    """

    label: str
    known: KnownShot
    result: Result
    agreement: Agreement
    margins: tuple[Margin, ...]
    states: tuple[BallStates, ...]
    attribution: Attribution | None
    factor: Factor | None = None
    fault: ContactFault | None = None
    contradiction: str = ""

    @property
    def scene(self) -> Scene:
        """The scene."""
        return self.known.scene

    @property
    def parting(self) -> Parting | None:
        """The first difference; None if every ball has the same collisions in both."""
        return self.agreement.parting

    @property
    def latest(self) -> tuple[Event, float] | None:
        """The shared collision with the largest time difference, and this difference [s].

        Positive means that the engine is late. None without shared collisions.
        """
        if not self.agreement.before:
            return None
        true, other = max(self.agreement.before, key=lambda pair: abs(pair[1].t - pair[0].t))
        return true, other.t - true.t

    @property
    def rest_distances(self) -> FloatArray:
        """Distance of each ball from its reference rest position, (n,) [m]."""
        between = self.result.rest_positions[:, :2] - self.known.positions(None)
        distances: FloatArray = np.hypot(*between.T)
        return distances

    @property
    def rest_time_difference(self) -> float:
        """Difference of the times at which the last ball stops [s]; positive if late."""
        return self.result.rest_time - self.known.result.rest_time

    @property
    def onset(self) -> tuple[float, Event | None] | None:
        """The time from which the motion differs [s], and the collision at which this begins.

        Without a collision: from the start. None if no ball is ever in a different position.
        """
        if self.factor is not None:
            since = self.factor.since
        else:
            times = np.linspace(0.0, self.result.rest_time, SAMPLE_COUNT)
            off = self.distances(times)
            since = float(times[max(int(np.argmax(off > VISIBLE_SHARE * np.max(off))) - 1, 0)])
            if not np.max(off) > 0.0:
                return None
        # A difference first visible at this time may begin at a collision before the next sample.
        spacing = self.result.rest_time / (SAMPLE_COUNT - 1)
        true = [one for one in events_in(events_of(self.known.result)) if one.t <= since + spacing]
        return since, true[-1] if true else None

    def distances(self, times: FloatArray) -> FloatArray:
        """Return the largest distance of a ball from the reference at some times, (k,) [m]."""
        return farthest(self.result, self.known.result, times)

    def to_dict(self) -> dict[str, Any]:
        """Return all fields as plain values, the object that `explain --format json` prints."""
        parting = self.parting
        latest = self.latest
        return {
            "schema": SCHEMA,
            "scene": self.scene.name,
            "engine": self.label,
            "settings": dict(self.result.settings),
            "status": status_name(self.result.status),
            "truth": {"by": self.known.kind, "why_not_certified": self.known.why},
            "agreed_collisions": len(self.agreement.before),
            "parting": None
            if parting is None
            else {
                "t": parting.t,
                "true": _event(parting.true),
                "engine": _event(parting.other),
                "margins": [vars(one) | {"event": _event(one.event)} for one in self.margins],
                "balls": [
                    {
                        "ball": one.ball,
                        "true": _state(one.true_position, one.true_velocity),
                        "engine": _state(one.position, one.velocity),
                    }
                    for one in self.states
                ],
            },
            "largest_time_difference": None
            if latest is None
            else {"event": _event(latest[0]), "seconds": latest[1]},
            "rest_differences": self.rest_distances.tolist(),
            "rest_time_difference": self.rest_time_difference,
            "contradiction": self.contradiction,
            "fault_at_contacts": None
            if self.fault is None
            else asdict(self.fault) | {"kind": self.fault.kind.label},
            "factor": None if self.factor is None else asdict(self.factor),
            "attribution": None if self.attribution is None else asdict(self.attribution),
        }


def explain(
    scene: Scene, engine: ReferenceEngine, *, label: str = "", attributed: bool = True
) -> Explanation:
    """Explain how an engine's run of a scene differs from the reference.

    `label`: the engine with its settings, as the user wrote it; default: its name.
    `attributed`: also compute the cause of the difference, which takes a few more runs.

    Raises `UnsupportedSceneError` if the engine lacks a feature of the scene; `EngineFailedError`
    if the engine fails, or reports a failure; `ExplanationError` if nothing moves, or if the engine
    itself is the reference; `GhostballError` if there is no reference.
    """
    moving = np.any(scene.velocities != 0.0) or np.any(scene.angular_velocities != 0.0)
    if not moving:
        raise ExplanationError(
            f'scene "{scene.name}": no ball moves, so there is nothing to explain. Give a ball a '
            "`velocity`"
        )
    if engine.name == "certified":
        raise ExplanationError("engine `certified` is itself the reference. Choose another engine")
    run = cache(partial(run_with_step, engine, scene, record="trajectory"))
    result = run(None)
    if result.status is Status.FAILED:
        raise EngineFailedError(engine.name, f"the engine reports a failure: {result.reason}")
    known = known_shot(scene)
    if engine.name == known.engine and known.kind == "our engine":
        raise ExplanationError(
            f'engine `{engine.name}` is itself the reference of scene "{scene.name}", which has no '
            f"closed form and isn't certified ({known.why}). Choose another engine"
        )
    agreement = _compare(known, result)
    parting = agreement.parting
    margins = () if parting is None else margins_of(known.result, result, agreement, parting)
    contradiction = contradiction_in(result, known)
    found, fault, factor = None, None, None
    if attributed and not contradiction:
        found = attribute(scene, engine, label=label, known=known, run=run)
        found = _unless_ambiguous(found, scene, agreement, margins)
        fault, factor = _causes(run, known, found)
        if fault is not None or factor is not None:
            found = replace(found, outcome="model")
    return Explanation(
        label=label or engine.name,
        known=known,
        result=result,
        agreement=agreement,
        margins=margins,
        states=() if parting is None else _states(known.result, result, parting),
        attribution=found,
        factor=factor,
        fault=fault,
        contradiction=contradiction,
    )


def _unless_ambiguous(
    found: Attribution, scene: Scene, agreement: Agreement, margins: tuple[Margin, ...]
) -> Attribution:
    """Return that a run agrees if the first different collision is ambiguous in the reference.

    The run agrees up to that collision if all earlier collisions have the right times.
    """
    parting = agreement.parting
    if parting is None or any(abs(a.t - b.t) > NEGLIGIBLE_TIME for a, b in agreement.before):
        return found
    diameter = 2.0 * float(scene.radii.max())
    least = min((one.length for one in margins if one.run == "truth"), default=diameter)
    # below this length, an engine may treat the balls as touching
    if least > CONTACT_TOLERANCE * diameter:
        return found
    until = f"{least:.2g} m decides which collision comes first: the reference is ambiguous"
    return replace(found, outcome="agrees", instant=parting.t, until=until)


def _causes(
    run: Callable[[float | None], Result], known: KnownShot, found: Attribution
) -> tuple[ContactFault | None, Factor | None]:
    """Return the error at contacts, or else the coefficient that explains the motion.

    Both are computed from the run with the shortest time step, so that an error of the step isn't
    mistaken for them.
    """
    to_the_end = found.outcome in ("rounding", "agrees") and found.instant is None
    ends_right = found.outcome == "step" and found.late is None  # with a shorter step
    if to_the_end or ends_right:
        return None, None
    result = run(found.ladder[-1].step if found.ladder else None)
    fault = fault_at_contacts(result)
    if fault is None and found.outcome in ("step", "agrees"):
        return None, None
    if fault is not None and fault.what == "slide":
        return fault, None
    factor = wrong_factor(known, result, found.instant)
    if fault is None or factor is None:
        return fault, factor
    if factor.acts_on_the_way or (fault.gains_energy and not factor.is_simple):
        return fault, None
    return None, factor


def _compare(known: KnownShot, result: Result) -> Agreement:
    true, other = events_in(events_of(known.result)), events_in(events_of(result))
    if not result.status.complete:  # later collisions can't be found by this run
        true = [one for one in true if one.t <= result.rest_time]
    return compare_logs(true, other)


def _states(truth: Result, result: Result, parting: Parting) -> tuple[BallStates, ...]:
    concerned = {
        ball: None for one in (parting.true, parting.other) if one is not None for ball in one.balls
    }
    # Just before, because at the time itself an exact motion is in the state after the collision.
    t = [max(float(np.nextafter(parting.t, 0.0)), 0.0)]
    true, other = truth.sample(t), result.sample(t)
    return tuple(
        BallStates(
            truth.scene.balls[ball].id,
            true.positions[0, ball, :2],
            true.velocities[0, ball, :2],
            other.positions[0, ball, :2],
            other.velocities[0, ball, :2],
        )
        for ball in sorted(concerned)
    )


def _event(one: Event | None) -> dict[str, Any] | None:
    """Return a collision as plain values, in the form of events in `run --format json`."""
    if one is None:
        return None
    b: int | str = partner_name(one.kind, one.b) if one.kind in OBSTACLE_KINDS else one.b
    return {"t": one.t, "kind": one.kind.label, "a": one.a, "b": b}


def _state(position: FloatArray, velocity: FloatArray) -> dict[str, list[float]]:
    return {"position": position.tolist(), "velocity": velocity.tolist()}
