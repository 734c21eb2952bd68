"""Work against precision: what each engine's time buys, against truth that owes nothing to ours."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence

from benchmarks.measurements import measured_where
from benchmarks.precision._ladders import (
    WIDE,
    Extent,
    ladder_of,
)
from benchmarks.precision._places import Course, Place
from benchmarks.precision.points import (
    LeftOut,
    PrecisionCurve,
    PrecisionMeasurement,
    PrecisionPoint,
    reach_of,
)
from benchmarks.running import BenchError
from benchmarks.timing import Clock, Samples, take_turns
from ghostball.engine import Scene
from ghostball.reference_adapters import EngineUnavailableError, ReferenceEngine, make_engine
from ghostball.reference_adapters.base import resolution_of
from ghostball.validation.parallel.pool import Progress
from ghostball.validation.results.records import CERTIFIED, INDEPENDENT
from ghostball.validation.suite.suite import DEFAULT_ENGINES
from ghostball.validation.truth.scene_truth import Truth, truth_of

TARGETS = (1e-3, 1e-6, 1e-9)
"""Accuracies whose time is told [m]."""

DEFAULT_SCENES = (
    "half-ball-cut",
    "moving-moving",
    "corner-double-bounce",
    "three-ball-chain",
    "cradle",
    "half-ball-rolling",
)
"""Each has a closed form. Balls roll in all but the last, where engines without sliding lack."""

QUICK_SCENES = ("half-ball-cut", "corner-double-bounce")

PRECISION_ENGINES = (
    *DEFAULT_ENGINES,
    "pymunk:iterations=1",
    "certified",
)
"""Besides those that are validated, a solver that iterates once, and the proof itself."""


def measure_precision(
    scenes: Sequence[Scene],
    engines: Sequence[str] = PRECISION_ENGINES,
    *,
    rounds: int,
    extent: Extent = WIDE,
    clock: Clock = time.perf_counter,
    progress: Progress[str] | None = None,
) -> PrecisionMeasurement:
    """Measure errors and times of engines over their ladders; Ctrl-C keeps what was measured.

    Parameters
    ----------
    scenes : sequence of Scene
        Each with a closed form, or proved to its end.
    engines : sequence of str
        Engines as for `make_engine`; each begins a ladder of steps, of which its own is one.
    rounds : int
        At most as many samples of each point.
    extent : Extent
        Any but `WIDE` is a trial.
    clock, progress
        As for `take_turns`.

    Raises
    ------
    BenchError
        Where a scene has no independent truth.
    EngineError
        Where an engine is unknown, or a setting is refused.
    """
    environment = measured_where()
    made = {label: _made(label) for label in dict.fromkeys(engines)}
    truths = [(scene, independent_truth(scene)) for scene in scenes]
    left_out: list[LeftOut] = []
    courses: list[list[Place]] = []
    for scene, truth in truths:
        for label, engine in made.items():
            course = Course(scene, truth, label)
            if isinstance(engine, str):
                left_out.append(course.left_out(label, f"unavailable: {engine}"))
            elif truth.kind == CERTIFIED and engine.name == "certified":
                left_out.append(course.left_out(label, "it is the truth here"))
            else:
                courses.append(list(_places(course, engine, extent, left_out)))
    places = list(_in_turns(courses))
    samples = take_turns([p.task() for p in places], rounds, clock=clock, progress=progress)
    left_out += _lost(courses)
    return _measurement(environment, rounds, extent, samples, courses, left_out)


def independent_truth(scene: Scene) -> Truth:
    """Return where the balls of a scene truly end.

    Raises
    ------
    BenchError
        Where it has no closed form and isn't proved to its end.
    """
    truth = truth_of(scene, parts={"rest"})
    if truth.kind in INDEPENDENT:
        return truth
    proof = truth.certificate
    why = truth.no_certificate if proof is None else f"{proof.ending}: {proof.reason}"
    raise BenchError(
        f'scene "{scene.name}" has no truth that is independent of our engine: it has no closed '
        f"form, and it isn't proved to its end ({why}). Leave it out"
    )


def _made(label: str) -> ReferenceEngine | str:
    """Return the engine, or why it can't run here."""
    try:
        return make_engine(label)
    except EngineUnavailableError as error:
        return str(error)


def _places(
    course: Course, engine: ReferenceEngine, extent: Extent, left_out: list[LeftOut]
) -> Iterator[Place]:
    """Yield a ladder's places; what can't be compared, or made, is left out."""
    truth = course.truth
    assert truth.rest_time is not None  # of every independent truth
    for rung in ladder_of(course.family, engine, truth.rest_time, extent):
        horizon = truth.horizon_of(resolution_of(rung.engine, course.scene))
        if horizon < truth.rest_time:
            why = f"past its horizon: from t = {horizon:.3g} s on its errors may change the course"
            left_out.append(course.left_out(rung.label, why))
        else:
            yield Place(course, rung)


def _in_turns(courses: Sequence[Sequence[Place]]) -> Iterator[Place]:
    """Yield the places scene by scene, and there level by level, engine by engine."""
    for scene in dict.fromkeys(p.course.scene.name for places in courses for p in places):
        mine = [places for places in courses if places and places[0].course.scene.name == scene]
        for level in range(max(map(len, mine))):
            yield from (places[level] for places in mine if level < len(places))


def _lost(courses: Sequence[Sequence[Place]]) -> Iterator[LeftOut]:
    for places in courses:
        if places and places[0].course.lost:
            course = places[0].course
            yield course.left_out(course.family, course.lost)
        else:
            yield from (p.course.left_out(p.rung.label, p.lost) for p in places if p.lost)


def _measurement(
    environment: dict[str, object],
    rounds: int,
    extent: Extent,
    samples: Samples,
    courses: Sequence[Sequence[Place]],
    left_out: Sequence[LeftOut],
) -> PrecisionMeasurement:
    points: list[PrecisionPoint] = []
    curves: list[PrecisionCurve] = []
    for places in courses:
        found = [point for place in places if (point := place.point()) is not None]
        points += found
        if found:
            lost = [p.rung.step for p in places if p.lost and p.rung.step is not None]
            reach = tuple(reach_of(target, found, lost) for target in TARGETS)
            curves.append(PrecisionCurve(scene=found[0].scene, engine=found[0].engine, reach=reach))
    return PrecisionMeasurement(
        environment=environment,
        rounds=rounds,
        quick=extent != WIDE,
        interrupted=samples.interrupted,
        points=tuple(points),
        curves=tuple(curves),
        left_out=tuple(left_out),
    )
