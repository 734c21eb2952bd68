"""Measure errors against run times, with references that are independent of Ghostball's engine."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from statistics import median
from typing import Any

import numpy as np

from ghostball.model import EngineFailedError, Record, Result, Scene, UnsupportedSceneError
from ghostball.reference_adapters import (
    EngineUnavailableError,
    ReferenceEngine,
    make_engine,
    parse_spec,
)
from ghostball.reference_adapters.base import resolution_of
from ghostball.reference_adapters.certified import CertifiedEngine, CertifiedSettings, certify
from ghostball.reference_adapters.certified.engine import result_of
from ghostball.reference_adapters.output import captured
from ghostball.reference_adapters.registry import spec_of
from ghostball.validation.checks.metric import RunAndTruth
from ghostball.validation.grading.event_logs import collisions_of
from ghostball.validation.parallel.pool import Progress
from ghostball.validation.precision.phases import start_of
from ghostball.validation.precision.points import LeftOut, PrecisionMeasurement, PrecisionPoint
from ghostball.validation.results.measurement import MeasurementError
from ghostball.validation.results.records import CERTIFIED, INDEPENDENT
from ghostball.validation.runs.engine_runs import run_engine
from ghostball.validation.runs.interleave import Sampler, Task, interleave
from ghostball.validation.runs.time_steps import halved_steps, step_of, step_setting, with_step
from ghostball.validation.suite.suite import DEFAULT_ENGINES
from ghostball.validation.truth.scene_truth import Truth, truth_of

DEFAULT_SCENES = (
    "half-ball-cut",
    "moving-moving",
    "corner-double-bounce",
    "three-ball-chain",
    "cradle",
    "half-ball-rolling",
)
"""Scenes with a closed form. Balls slide only in the last, which some engines don't support."""

PRECISION_ENGINES = (*DEFAULT_ENGINES, "pymunk:iterations=1", "certified")
"""The validated engines, a solver with one iteration, and the certified engine."""

LEAST_SAMPLE, MOST_RUNS = 5e-3, 50
"""Least duration of a sample [s], and the largest number of runs in a sample."""

MANY_STEPS, FEW_SAMPLES = 5_000, 2
"""A shot with more steps has only this number of samples. The limit counts steps, not time, so that
phases and errors are the same on every machine."""


@dataclass(frozen=True, eq=False)
class EngineAtStep:
    """One engine with all of its settings.

    `family`: the engine as the user named it: one curve.
    `label`: the same with the time step of this point.
    `step` [s]: None for an engine without a time step, which has one point only.
    """

    family: str
    label: str
    engine: ReferenceEngine
    step: float | None

    def simulate(self, scene: Scene) -> tuple[Result, float]:
        """Run a scene to its end; return the result and the run time of the whole call [s].

        A certified result is always computed: a stored one would take no time.
        """
        if not isinstance(self.engine, CertifiedEngine):
            # Time-stepping engines record their collisions for the comparison; exact engines are
            # timed without a log.
            record: Record = "rest" if self.step is None else "events"
            timed: Any = _TimedEngine(self.engine)
            with captured():
                result = run_engine(timed, scene, record)
            return result, float(timed.seconds)
        self.engine.check(scene)
        settings: CertifiedSettings = self.engine.settings
        began = time.perf_counter()
        result = result_of(scene, certify(scene, settings, cached=False), settings, "rest")
        return result, time.perf_counter() - began


class _TimedEngine:
    """An engine that measures the run time of each call, without the checks around it."""

    def __init__(self, engine: ReferenceEngine) -> None:
        self.engine = engine
        self.seconds = math.nan

    def __getattr__(self, name: str) -> Any:
        """Return other attributes from the engine, such as its name."""
        return getattr(self.engine, name)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Run the scene on the engine, and store the duration of the call [s]."""
        began = time.perf_counter()
        result = self.engine.simulate(scene, record=record)
        self.seconds = time.perf_counter() - began
        return result


def ladder_of(family: str, engine: ReferenceEngine, duration: float) -> Iterator[EngineAtStep]:
    """Yield an engine with each of its time steps, the longest first; or the engine itself.

    `family`: the engine as the user named it.
    `duration` [s]: of the shot.
    """
    own, name = step_of(engine), step_setting(engine)
    if own is None or name is None:
        yield EngineAtStep(family, family, engine, None)
        return
    known_as, settings = parse_spec(family)
    for step in halved_steps(own, duration):
        label = spec_of(known_as, {**settings, name: repr(step)})
        yield EngineAtStep(family, label, with_step(engine, step), step)


@dataclass(eq=False)
class PlannedPoint:
    """One point to be measured; each sample starts the shot at another phase of the time step.

    `samples`: for each sample, the least time of a whole call [s], the least time that the engine
        reports [s], that in the engine's own steps [s] or None, the largest error [m], and whether
        the events were right.
    `why_not`: the error of a failed run; then there is no point.
    """

    scene: Scene
    truth: Truth
    at_step: EngineAtStep
    level: int
    samples: list[tuple[float, float, float | None, float, bool]] = field(default_factory=list)
    why_not: str = ""

    def task(self) -> Task:
        """Return the measurement task; the first step of each engine is run once before."""
        step, duration = self.at_step.step, self.truth.rest_time
        assert duration is not None  # every independent reference has a rest time
        slow = step is not None and duration > MANY_STEPS * step

        def prepare() -> Sampler:
            if self.level == 0:
                self._run(self.scene)
            return self._sample

        return Task(
            f"{self.scene.name}, {self.at_step.label}", prepare, FEW_SAMPLES if slow else None
        )

    def _sample(self) -> dict[str, float]:
        start = start_of(self.scene, self.at_step.step, len(self.samples))
        began = time.perf_counter()
        runs: list[tuple[Result, float]] = []
        while len(runs) < MOST_RUNS and (not runs or time.perf_counter() - began < LEAST_SAMPLE):
            run = None if self.why_not else self._run(start)
            if run is None:
                return {}
            runs.append(run)
        call_seconds = min(seconds for _, seconds in runs)
        inside = min(result.wall_time for result, _ in runs)
        steps = [result.engine_time for result, _ in runs if result.engine_time is not None]
        first, _ = runs[0]
        error = float(np.max(RunAndTruth(first, self.truth).ball_errors))
        same_events = _has_same_events(first, self.truth)
        self.samples.append((call_seconds, inside, min(steps, default=None), error, same_events))
        return {"seconds": call_seconds}

    def _run(self, scene: Scene) -> tuple[Result, float] | None:
        """Run a shot and time the whole call; if it failed, store the reason and return None."""
        try:
            result, seconds = self.at_step.simulate(scene)
        except UnsupportedSceneError as error:
            self.why_not = f"unsupported: {'; '.join(error.features)}"
        except EngineFailedError as error:
            self.why_not = f"failed: {error.reason}"
        else:
            if result.status.complete:
                return result, seconds
            self.why_not = f"stopped early: {result.reason or result.status.value}"
        return None

    def found(self) -> PrecisionPoint | LeftOut:
        """Return the point, or why there is none."""
        at_step = self.at_step
        if self.why_not:
            return LeftOut(
                scene=self.scene.name, engine=at_step.family, why=self.why_not, step=at_step.step
            )
        calls, inside, steps, errors, all_same = zip(*self.samples, strict=True)
        return PrecisionPoint(
            scene=self.scene.name,
            title=self.scene.title,
            truth=self.truth.kind or "",
            engine=at_step.family,
            label=at_step.label,
            step=at_step.step,
            call_seconds=min(calls),
            seconds=min(inside),
            samples=len(calls),
            error=median(errors),
            error_low=min(errors),
            error_high=max(errors),
            same_events=all(all_same),
            engine_seconds=min((one for one in steps if one is not None), default=None),
        )


def _has_same_events(result: Result, truth: Truth) -> bool:
    """Return True if the same bodies collided as in the reference.

    The number of collisions may differ if events are recorded: in a line of touching balls, a
    time-stepping engine may report a contact again at the next step.
    """
    if result.events is None or truth.collisions is None:
        return dict(result.collision_counts) == truth.collision_counts
    return set(collisions_of(result.events)[0]) == set(truth.collisions)


def measure_precision(
    scenes: Sequence[Scene],
    engines: Sequence[str] = PRECISION_ENGINES,
    *,
    rounds: int,
    progress: Progress[str] | None = None,
) -> PrecisionMeasurement:
    """Measure errors and run times of engines with several time steps.

    `scenes`: each with a closed form, or certified to its end.
    `engines`: as for `make_engine`; each is measured with several time steps, including its own.
    `rounds`: largest number of samples of each point.
    """
    truths = [(scene, independent_truth(scene)) for scene in scenes]
    places: list[PlannedPoint] = []
    left_out: list[LeftOut] = []
    for label in dict.fromkeys(engines):
        try:
            engine, why = make_engine(label), ""
        except EngineUnavailableError as error:
            why = f"unavailable: {error}"
        for scene, truth in truths:
            if not why and truth.kind == CERTIFIED and engine.name == "certified":
                left_out.append(
                    LeftOut(scene=scene.name, engine=label, why="it is the reference here")
                )
            elif why:
                left_out.append(LeftOut(scene=scene.name, engine=label, why=why))
            else:
                assert truth.rest_time is not None  # every independent reference has a rest time
                level = 0
                for at_step in ladder_of(label, engine, truth.rest_time):
                    horizon = truth.horizon_of(resolution_of(at_step.engine, scene))
                    if horizon < truth.rest_time:
                        past = f"after its horizon, {horizon:.3g} s, errors may change the events"
                        left_out.append(LeftOut(scene=scene.name, engine=at_step.label, why=past))
                    else:
                        places.append(PlannedPoint(scene, truth, at_step, level))
                        level += 1
    order = {scene.name: k for k, scene in enumerate(scenes)}
    turns = sorted(places, key=lambda place: (order[place.scene.name], place.level))
    interleave([place.task() for place in turns], rounds, progress)
    found = [place.found() for place in sorted(places, key=lambda p: order[p.scene.name])]
    return PrecisionMeasurement(
        rounds=rounds,
        points=tuple(one for one in found if isinstance(one, PrecisionPoint)),
        left_out=(*left_out, *(one for one in found if isinstance(one, LeftOut))),
    )


def independent_truth(scene: Scene) -> Truth:
    """Return a reference for the end of a scene that is independent of Ghostball's engine."""
    truth = truth_of(scene, parts={"rest"})
    if truth.kind in INDEPENDENT:
        return truth
    certificate = truth.certificate
    why = (
        truth.no_certificate
        if certificate is None
        else f"{certificate.ending}: {certificate.reason}"
    )
    raise MeasurementError(
        f'scene "{scene.name}" has no reference that is independent of Ghostball: it has no '
        f"closed form, and it isn't certified to its end ({why}). Remove the scene"
    )
