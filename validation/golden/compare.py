"""Compare the answer of an engine to a golden shot, as the README of the golden shots describes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ghostball.model import COLLISION_KINDS, EventKind, Result, Scene
from ghostball.reference_adapters.answer import EngineAnswer
from ghostball.validation.golden.format import GoldenShot
from ghostball.validation.grading.event_logs import Event, events_in

ALWAYS = (*COLLISION_KINDS, EventKind.POCKETED)
"""Kinds of events that every engine must report."""

PHASE_ENDS = (EventKind.SLIDE_TO_ROLL, EventKind.ROLL_TO_REST, EventKind.BALL_CLOTH)
"""Kinds of events that end a slide, roll or flight, which may be too short for doubles."""


@dataclass(frozen=True)
class Comparison:
    """Result of the comparison of an answer with a golden shot.

    `faults`: a sentence for each missing or extra event and each number outside its tolerance.
    `factor`: the largest error in units of its tolerance; inf if an event is missing or extra, or
        if a number isn't finite.
    `error` [m]: largest error of a coordinate of a rest position; None if they can't be compared.
    """

    faults: tuple[str, ...]
    factor: float
    error: float | None


def answer_of(shot: GoldenShot, value: object, engine: str, where: str) -> Result:
    """Return an answer, `{"events": ..., "rest_positions": ...}`, as a `Result`.

    Raises `EngineError` if it is invalid; the message calls it `where`.
    """
    known = {"engine": engine, "scene": shot.scene.name, "status": "rest", "rest_time": 0.0}
    answer = {**value, **known} if isinstance(value, dict) else value
    return EngineAnswer.parse(answer, where).result(shot.scene, record="events", where=where)


def compare(shot: GoldenShot, answer: Result) -> Comparison:
    """Compare an answer with the golden shot of its scene."""
    scene = shot.scene
    plain = shot.model_dump(include={"events", "rest_positions"})
    plain["rest_positions"] = plain["rest_positions"] or scene.positions
    events = answer_of(shot, plain, "reference", scene.name).events
    assert events is not None
    assert answer.events is not None
    left = events_in(answer.events, tuple(EventKind))
    kinds = {*ALWAYS, *(one.kind for one in left)}
    true = list(zip(events_in(events, tuple(EventKind)), shot.tolerance.events, strict=True))
    faults, factors = [], [0.0]
    for event, tolerance in true:
        if event.kind not in kinds:
            continue
        same = [one for one in left if one.key == event.key]
        if not same:
            faults.append(f"{_words(event, scene)} is missing")
            factors.append(math.inf)
            continue
        found = min(same, key=lambda one: abs(one.t - event.t))
        left.remove(found)
        factors.append(_factor(found.t - event.t, tolerance))
        if factors[-1] > 1.0:
            late = f"reported at t = {found.t:.17g} s, {factors[-1]:.3g} tolerances off"
            faults.append(f"{_words(event, scene)} is {late}")
    ends = math.inf
    if shot.valid_until is not None:
        ends = shot.valid_until - shot.tolerance.events[-1]
    for extra in left:
        near = (abs(e.t - extra.t) <= tolerance for e, tolerance in true if extra.a in e.balls)
        if extra.t < ends and not (extra.kind in PHASE_ENDS and any(near)):
            faults.append(f"{_words(extra, scene)} is not in the reference")
            factors.append(math.inf)
    if shot.rest_positions is None or shot.tolerance.rest_positions is None:
        return Comparison(tuple(faults), max(factors), None)
    errors = np.max(np.abs(answer.rest_positions - np.array(shot.rest_positions)), axis=1).tolist()
    for ball, error, tolerance in zip(
        scene.balls, errors, shot.tolerance.rest_positions, strict=True
    ):
        factors.append(_factor(error, tolerance))
        if factors[-1] > 1.0:
            faults.append(
                f'rest position of "{ball.id}" is {error:.3g} m off: {factors[-1]:.3g} tolerances'
            )
    return Comparison(tuple(faults), max(factors), max(errors))


def _factor(error: float, tolerance: float) -> float:
    """Return an error in units of its tolerance; inf if it isn't finite."""
    return abs(error) / tolerance if math.isfinite(error) else math.inf


def _words(event: Event, scene: Scene) -> str:
    return f"{event.describe(scene)} at t = {event.t:.17g} s"
