"""One point of errors against time while it is measured: its runs, and why one is lost."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from statistics import median

import numpy as np

from benchmarks.precision._ladders import Rung, start_of, work_of
from benchmarks.precision.points import LeftOut, PrecisionPoint
from benchmarks.timing import Clock, Task
from ghostball.engine import EngineFailedError, Result, Scene, UnsupportedSceneError
from ghostball.validation.checks.metrics import ball_errors
from ghostball.validation.grading.event_logs import collisions_of
from ghostball.validation.truth.scene_truth import Truth

LEAST_SAMPLE, MOST_RUNS = 5e-3, 50
"""A sample is the least of several runs where one is so short [s]: at most so many."""

MANY_STEPS, FEW = 5_000, 2
"""A shot that takes more steps is sampled only so often; by steps, for time would make the phases,
and with them the errors, differ from machine to machine."""


@dataclass(frozen=True)
class Sample:
    """One timed run: least seconds, largest error [m], work, and whether its course is true."""

    seconds: float
    error: float
    work: tuple[str, int]
    true_course: bool


@dataclass(eq=False)
class Course:
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
class Place:
    """One point to be measured: each turn begins the shot at another part of a step."""

    course: Course
    rung: Rung
    samples: list[Sample] = field(default_factory=list)
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

    def _measured(self, result: Result, seconds: float) -> Sample:
        truth = self.course.truth
        return Sample(
            seconds,
            float(np.max(ball_errors(result, truth))),
            work_of(result),
            _took_course(result, truth),
        )

    def _run(self, scene: Scene) -> Result | None:
        """Run a shot; None where that went wrong, which is noted."""
        try:
            result = self.rung.simulate(scene)
        except UnsupportedSceneError as error:
            why = f"not representable: {'; '.join(error.features)}"
            if self.course.sampled:  # it can play the scene, but not at this step
                self.lost = why
            else:
                self.course.lost = why
            return None
        except EngineFailedError as error:
            self.lost = f"failed: {error.reason}"
            return None
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
            samples=len(seconds),
            error=median(errors),
            error_low=min(errors),
            error_high=max(errors),
            work_name=work_name,
            work=work,
            exact=self.rung.step is None,
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
