"""Work against precision: what each engine's time buys, against truth that owes nothing to ours."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from statistics import median

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from engine import Result, Scene, Status, UnsupportedSceneError
from reference_adapters import EngineUnavailableError, ReferenceEngine, make_engine
from reference_adapters.base import resolution_of
from validation.bench._ladders import (
    TINY,
    WIDE,
    Extent,
    Rung,
    at_step,
    ladder_of,
    start_of,
    work_of,
)
from validation.bench._points import (
    LeftOut,
    PrecisionCurve,
    PrecisionMeasurement,
    PrecisionPoint,
    best_of,
)
from validation.bench._reach import NO_STEP, TARGETS, Level, Reach, order_of, reach_of
from validation.bench.measurements import measured_where
from validation.bench.running import BenchError
from validation.bench.timing import Clock, Progress, Samples, Task, take_turns
from validation.metrics import ball_errors
from validation.records import CERTIFIED, INDEPENDENT
from validation.returned import check_result
from validation.suite import DEFAULT_ENGINES
from validation.truth import Truth, collisions_of, truth_of

__all__ = [
    "DEFAULT_SCENES",
    "NO_STEP",
    "PRECISION_ENGINES",
    "QUICK_SCENES",
    "TARGETS",
    "TINY",
    "WIDE",
    "Extent",
    "LeftOut",
    "PrecisionCurve",
    "PrecisionMeasurement",
    "PrecisionPoint",
    "Reach",
    "best_of",
    "measure_precision",
]

FloatArray = NDArray[np.float64]

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

LEAST_SAMPLE, MOST_RUNS = 5e-3, 50
"""A sample is the least of several runs where one is so short [s]: at most so many."""

MANY_STEPS, FEW = 5_000, 2
"""A shot that takes more steps is sampled only so often; by steps, for time would make the phases,
and with them the errors, differ from machine to machine."""


@dataclass(frozen=True)
class _Sample:
    """One timed run: least seconds, largest error [m], where the balls end (n, 2) [m]."""

    seconds: float
    error: float
    positions: FloatArray
    work: tuple[str, int]
    true_course: bool


@dataclass(eq=False)
class _Course:
    """One engine on one scene; `lost` says why it isn't asked at all, so that it has no points."""

    scene: Scene
    truth: Truth
    family: str
    lost: str = ""
    warm: bool = False
    sampled: bool = False

    def left_out(self, label: str, why: str) -> LeftOut:
        return LeftOut(scene=self.scene.name, engine=label, why=why)


@dataclass(eq=False)
class _Place:
    """One point to be measured: each turn begins the shot at another part of a step."""

    course: _Course
    rung: Rung
    samples: list[_Sample] = field(default_factory=list)
    lost: str = ""

    @property
    def name(self) -> str:
        return f"{self.course.scene.name}, {self.rung.label}"

    def task(self) -> Task:
        return Task(self.name, self._prepare)

    def _prepare(self) -> Callable[[Clock], dict[str, float]]:
        course = self.course
        if not course.warm:
            course.warm = True  # also where it fails, for then it is lost
            self._run(course.scene)
        return self._sample

    def _sample(self, clock: Clock) -> dict[str, float]:
        if self._is_done():
            return {}
        course = self.course
        start = start_of(course.scene, self.rung, len(self.samples))
        if start is None:  # something touches it: it can't begin any earlier
            start = course.scene
        began = clock()
        results: list[Result] = []
        while not results or (len(results) < MOST_RUNS and clock() - began < LEAST_SAMPLE):
            result = self._run(start)
            if result is None:
                return {}
            results.append(result)
        best = min(one.wall_time for one in results)
        self.samples.append(self._measured(results[0], best))
        course.sampled = True
        return {"seconds": best}

    def _is_done(self) -> bool:
        enough = len(self.samples) >= FEW and self._takes_many_steps
        return enough or bool(self.lost or self.course.lost)

    @property
    def _takes_many_steps(self) -> bool:
        step, duration = self.rung.step, self.course.truth.rest_time
        return step is not None and duration is not None and duration > MANY_STEPS * step

    def _measured(self, result: Result, seconds: float) -> _Sample:
        truth = self.course.truth
        return _Sample(
            seconds,
            float(np.max(ball_errors(result, truth))),
            result.rest_positions[:, :2],
            work_of(result),
            _took_course(result, truth),
        )

    def _run(self, scene: Scene) -> Result | None:
        """Run a shot; None where that went wrong, which is noted."""
        name = self.rung.engine.name
        try:
            result = self.rung.simulate(scene)
            check_result(result, scene, name)
        except UnsupportedSceneError as error:
            why = f"not representable: {'; '.join(error.features)}"
            if self.course.sampled:  # it can play the scene, but not at this step
                self.lost = why
            else:
                self.course.lost = why
            return None
        # An engine may raise anything, and its `sys.exit` must not end the measurement.
        except (Exception, SystemExit) as error:
            self.lost = f"failed: {type(error).__name__}: {error}"
            return None
        if result.status is Status.INTERRUPTED:
            raise KeyboardInterrupt
        if not result.status.complete:
            self.lost = f"stopped early: {result.reason or result.status.value}"
            return None
        return result

    def point(self) -> PrecisionPoint | None:
        if not self.samples or self.lost:
            return None
        seconds = [one.seconds for one in self.samples]
        errors = [one.error for one in self.samples]
        work_name, work = self.samples[0].work
        course = self.course
        return PrecisionPoint(
            scene=course.scene.name,
            title=course.scene.title,
            truth=course.truth.kind or "",
            engine=course.family,
            label=self.rung.label,
            step=self.rung.step,
            seconds=min(seconds),
            seconds_median=median(seconds),
            samples=len(seconds),
            error=median(errors),
            error_low=min(errors),
            error_high=max(errors),
            work_name=work_name,
            work=work,
            exact=self.rung.step is None,
            true_course=self._true_course,
        )

    def level(self) -> Level:
        """Return what order and reach depend on, of a place that has a point."""
        return Level(
            step=self.rung.step,
            seconds=min(one.seconds for one in self.samples),
            worst=max(one.error for one in self.samples),
            states=np.array([one.positions for one in self.samples]),
            true_course=self._true_course,
        )

    @property
    def _true_course(self) -> bool:
        return all(one.true_course for one in self.samples)


def _took_course(result: Result, truth: Truth) -> bool:
    """Whether those met that meet in truth.

    Not how often, of a run with its events: in a row of balls that touch, an engine that steps may
    report a contact again at the next step.
    """
    if result.events is None or truth.collisions is None:
        return dict(result.collision_counts) == truth.collision_counts
    return set(collisions_of(result.events)[0]) == set(truth.collisions)


def measure_precision(
    scenes: Sequence[Scene],
    engines: Sequence[str] = PRECISION_ENGINES,
    *,
    rounds: int,
    extent: Extent = WIDE,
    clock: Clock = time.perf_counter,
    progress: Progress | None = None,
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
    courses: list[list[_Place]] = []
    for scene, truth in truths:
        for label, engine in made.items():
            course = _Course(scene, truth, label)
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
    course: _Course, engine: ReferenceEngine, extent: Extent, left_out: list[LeftOut]
) -> Iterator[_Place]:
    """Yield a ladder's places; what can't be compared, or made, is left out."""
    truth = course.truth
    assert truth.rest_time is not None  # of every independent truth
    for rung in ladder_of(course.family, engine, truth.rest_time, extent):
        horizon = truth.horizon_of(resolution_of(rung.engine, course.scene))
        if horizon < truth.rest_time:
            why = f"past its horizon: from t = {horizon:.3g} s on its errors may change the course"
            left_out.append(course.left_out(rung.label, why))
        else:
            yield _Place(course, rung)


def _in_turns(courses: Sequence[Sequence[_Place]]) -> Iterator[_Place]:
    """Yield the places scene by scene, and there level by level, engine by engine."""
    for scene in dict.fromkeys(p.course.scene.name for places in courses for p in places):
        mine = [places for places in courses if places and places[0].course.scene.name == scene]
        for level in range(max(map(len, mine))):
            yield from (places[level] for places in mine if level < len(places))


def _lost(courses: Sequence[Sequence[_Place]]) -> Iterator[LeftOut]:
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
    courses: Sequence[Sequence[_Place]],
    left_out: Sequence[LeftOut],
) -> PrecisionMeasurement:
    points: list[PrecisionPoint] = []
    curves: list[PrecisionCurve] = []
    for places in courses:
        found = [(place, place.point()) for place in places]
        points += [point for _, point in found if point is not None]
        if measured := [place for place, point in found if point is not None]:
            lost = [p.rung.step for p in places if p.lost and p.rung.step is not None]
            curves.append(_curve(measured, lost))
    return PrecisionMeasurement(
        environment=environment,
        rounds=rounds,
        quick=extent != WIDE,
        interrupted=samples.interrupted,
        points=tuple(points),
        curves=tuple(curves),
        left_out=tuple(left_out),
    )


def _curve(places: Sequence[_Place], lost: Sequence[float]) -> PrecisionCurve:
    course, finest = places[0].course, places[-1].rung
    assert course.truth.rest_positions is not None  # of every independent truth
    assert course.truth.rest_time is not None
    truth, duration = course.truth.rest_positions[:, :2], course.truth.rest_time
    levels = [place.level() for place in places]
    order = order_of(levels, truth)

    def accepts(step: float) -> bool:
        try:
            at_step(finest, step)
        except ValidationError:
            return False
        return True

    return PrecisionCurve(
        scene=course.scene.name,
        engine=course.family,
        order=order.value,
        order_note=order.note,
        limit_beside=order.beside,
        reach=tuple(reach_of(t, levels, order, duration, accepts, lost) for t in TARGETS),
    )
