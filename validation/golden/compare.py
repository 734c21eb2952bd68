"""Compare the answer of an engine to a golden shot, as the README of the golden shots describes."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ghostball.model import COLLISION_KINDS, EventKind, Result, Scene, partner_name
from ghostball.reference_adapters.answer import EngineAnswer, RunEvent, event_row
from ghostball.reference_adapters.base import EngineError
from ghostball.reference_adapters.returned import partners_of
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
    `factor`: the largest finite error in units of its tolerance; missing and extra events don't
        count. None if nothing can be compared.
    `error` [m]: largest error of a coordinate of a rest position; None if they can't be compared.
    """

    faults: tuple[str, ...]
    factor: float | None
    error: float | None


def answer_of(shot: GoldenShot, value: object, engine: str, where: str) -> Result:
    """Return an answer, `{"events": ..., "rest_positions": ...}`, as a `Result`.

    The rest positions may be None or missing if the shot has none.

    Raises `EngineError` if it is invalid; the message calls it `where`.
    """
    keys, scene = ("events", "rest_positions"), shot.scene
    if not isinstance(value, dict):
        rule = "must be an object with `events` and `rest_positions`"
        raise EngineError(f"{where} {rule}, got {_json(value)}")
    given = {key: value[key] for key in keys if key in value}
    if shot.rest_positions is None and given.get("rest_positions") is None:
        given["rest_positions"] = scene.positions
    if lacks := [key for key in keys if key not in given]:
        raise EngineError(f"{where}: `{lacks[0]}` is missing")
    known = {"engine": engine, "scene": scene.name, "status": "rest", "rest_time": 0.0}
    answer = EngineAnswer.parse(given | known, where)
    result = answer.result(scene, record="events", where=where)
    for k, event in enumerate(answer.events):
        _check_bodies(event, scene, f"{where}: `events[{k}]")
    for ball, axis in np.argwhere(~np.isfinite(answer.rest_positions)).tolist():
        got = float(answer.rest_positions[ball, axis])
        key = f"rest_positions[{ball}][{axis}]"
        raise EngineError(f"{where}: `{key}` must be a finite number, got {got!r}")
    return result


def _check_bodies(event: RunEvent, scene: Scene, where: str) -> None:
    """Check that an event names balls of the scene, and the cushion or pocket that its kind needs.

    Raises `EngineError` if it doesn't; `where` is as in `event_row`.
    """
    _, number, _, partner = event_row(event, scene.table, where)
    kind, last = EventKind(number), len(scene.balls) - 1
    for key, ball in (("a", event.a), ("b", event.b))[: 1 + (kind is EventKind.BALL_BALL)]:
        if not isinstance(ball, int) or not 0 <= ball <= last:
            rule = f"must be the index of a ball, 0 to {last}"
            raise EngineError(f"{where}.{key}` {rule}, got {_json(ball)} (indices start at 0)")
    if kind is EventKind.BALL_BALL:
        if event.a == event.b:
            raise EngineError(f"{where}.b` must be another ball than `a`, got {event.b} for both")
        return
    partners = partners_of(scene.table).get(kind, [-1])
    if partner not in partners:
        names = "null" if partners == [-1] else ", ".join(partner_name(kind, k) for k in partners)
        rule = f"must be {names or 'an obstacle of this scene, which has none,'}"
        raise EngineError(f"{where}.b` {rule} for the kind {kind.label}, got {_json(event.b)}")


def compare(shot: GoldenShot, answer: Result, tolerances: float = 1.0) -> Comparison:
    """Compare an answer with the golden shot of its scene.

    `tolerances`: each tolerance is multiplied by this number.
    """
    scene = shot.scene
    plain = shot.model_dump(include={"events", "rest_positions"})
    events = answer_of(shot, plain, "reference", scene.name).events
    assert events is not None
    assert answer.events is not None
    left = events_in(answer.events, tuple(EventKind))
    kinds = {*ALWAYS, *(one.kind for one in left)}
    true = list(zip(events_in(events, tuple(EventKind)), shot.tolerance.events, strict=True))
    faults: list[str] = []
    factors: list[float] = []
    for event, tolerance in true:
        if event.kind not in kinds:
            continue
        same = [one for one in left if one.key == event.key]
        if not same:
            faults.append(f"{_words(event, scene)} is missing")
            continue
        found = min(same, key=lambda one: abs(one.t - event.t))
        left.remove(found)
        factors.append(abs(found.t - event.t) / tolerance)
        if factors[-1] > tolerances:
            late = f"reported at t = {found.t:.17g} s, {factors[-1]:.3g} tolerances off"
            faults.append(f"{_words(event, scene)} is {late}")
    ends = math.inf
    if shot.valid_until is not None:
        ends = shot.valid_until - tolerances * shot.tolerance.events[-1]
    for extra in left:
        near = (
            abs(event.t - extra.t) <= tolerances * tolerance
            for event, tolerance in true
            if extra.a in event.balls
        )
        if extra.t < ends and not (extra.kind in PHASE_ENDS and any(near)):
            faults.append(f"{_words(extra, scene)} is not in the reference")
    if shot.rest_positions is None or shot.tolerance.rest_positions is None:
        return Comparison(tuple(faults), _largest(factors), None)
    errors = np.max(np.abs(answer.rest_positions - np.array(shot.rest_positions)), axis=1).tolist()
    for ball, error, tolerance in zip(
        scene.balls, errors, shot.tolerance.rest_positions, strict=True
    ):
        factors.append(error / tolerance)
        if factors[-1] > tolerances:
            faults.append(
                f'rest position of "{ball.id}" is {error:.3g} m off: {factors[-1]:.3g} tolerances'
            )
    return Comparison(tuple(faults), _largest(factors), max(errors))


def _largest(factors: Sequence[float]) -> float | None:
    return max(filter(math.isfinite, factors), default=None)


def _json(value: object) -> str:
    return json.dumps(value)[:80]


def _words(event: Event, scene: Scene) -> str:
    return f"{event.describe(scene)} at t = {event.t:.17g} s"
