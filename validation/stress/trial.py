"""A trial: one thing that an engine must survive, and what is found when it is tried.

>>> trial = SceneTrial("head-on", scene, Keeps(("energy", "overlap")))
>>> trial.run(make_engine("pymunk"))
Verdict(faults=(), ...)

A trial is plain data, so that another process can run it; what it asks for is known beforehand: a
right answer, or something that no shot may break.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal

from ghostball.model import ExactTrajectory, GhostballError, Record, Result, Scene
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.checks.law import asked_of
from ghostball.validation.runs.playing import run_engine
from ghostball.validation.suite.case import plain_settings
from ghostball.validation.suite.judge import checks_on
from ghostball.validation.truth.scene_truth import Truth

Suite = Literal["quick", "full"]
"""How much is tried: what a CI has time for, or all."""


NOT_FINITE = 1e6
"""Severity of a verdict on numbers that are NaN or infinite."""

CRASHED = 1e9
"""Severity of a trial that gave no verdict: nothing is worse."""


class StressError(GhostballError, ValueError):
    """A stress run that can't start, or a folder of one that can't be read."""


class NotJudgedError(GhostballError):
    """A trial can't be judged, because no limit applies to what the engine did."""


@dataclass(frozen=True)
class Verdict:
    """What was found.

    `faults`: what broke, one sentence each, with the numbers; empty where the engine survived.
    `scene`: the shot that broke worst, or, where none did, the one that came nearest; None where
        there is no such shot.
    `severity`: how near to breaking, of trials of one family: the greatest is shown as its worst
        case. From 1 on where it broke.
    `shots`: how many shots were judged.
    `broken`: how many of them broke.
    `values`: what was measured; plain values, as JSON has them.
    """

    faults: tuple[str, ...] = ()
    scene: Scene | None = None
    severity: float = 0.0
    shots: int = 1
    broken: int = 0
    values: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Give what has no finite severity, for its numbers have none, one that can be written."""
        if not math.isfinite(self.severity):
            object.__setattr__(self, "severity", NOT_FINITE)

    @classmethod
    def of(
        cls,
        scene: Scene,
        faults: Iterable[str],
        severity: float = 0.0,
        values: Mapping[str, Any] | None = None,
    ) -> Verdict:
        """Return the verdict on one shot."""
        found = tuple(faults)
        near = graded_severity(severity, bool(found))
        return cls(found, scene, near, 1, bool(found), values or {})

    @classmethod
    def of_all(cls, verdicts: Sequence[Verdict]) -> Verdict:
        """Return the verdict on several shots: the worst one's scene and values stand for them."""
        worst = max(verdicts, key=lambda one: (one.broken, one.severity))
        faults = tuple(
            f"{one.scene.name}: {fault}"
            for one in verdicts
            if one.scene is not None
            for fault in one.faults
        )
        broken = sum(one.broken for one in verdicts)
        return cls(faults, worst.scene, worst.severity, len(verdicts), broken, worst.values)

    def joined(self, other: Verdict) -> Verdict:
        """Return the verdict of this judge and of another one on the same shot."""
        assert self.scene is not None
        return Verdict.of(
            self.scene,
            (*self.faults, *other.faults),
            max(self.severity, other.severity),
            {**self.values, **other.values},
        )


def graded_severity(nearness: float, broken: bool) -> float:
    """Return the severity of what came so near to a limit, or went so far beyond: a ratio to it.

    From 1 to `NOT_FINITE` where it broke, below 1 where it did not, whatever the ratio: of several
    limits it may belong to another one than the fault does.
    """
    if not broken:
        return min(nearness, 0.999) if nearness >= 0.0 else 0.0
    return max(min(nearness, NOT_FINITE), 1.0) if math.isfinite(nearness) else NOT_FINITE


class Trial(ABC):
    """One thing to try. Subclasses are frozen dataclasses of plain values, and have a `name`.

    `name`: unique within its family; letters, digits and "-+=.,", for it is part of file names.
    `limit` [s]: its process is ended if it takes longer; what it then did is a fault.
    """

    name: str
    limit: ClassVar[float] = 60.0

    @abstractmethod
    def run(self, engine: ReferenceEngine) -> Verdict:
        """Try it.

        Raises `UnsupportedSceneError` where the engine can't represent it.
        """

    def examples(self) -> Iterable[Scene]:
        """Yield scenes that need the same kernels: these are compiled before the clock runs."""
        scene = getattr(self, "scene", None)
        return () if scene is None else (scene,)


Judge = Callable[[Result], Verdict]
"""Looks at a run: a frozen dataclass with `__call__`, or a function of a module."""


@dataclass(frozen=True)
class SceneTrial(Trial):
    """One shot, run once and judged.

    `judge`: given the result, returns the verdict. It sees whole results of this scene only.
    """

    name: str
    scene: Scene
    judge: Judge
    record: Record = "trajectory"

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Run the shot and judge it; a run that stops early, or isn't finite, is a fault."""
        result = play(engine, self.scene, self.record)
        return result if isinstance(result, Verdict) else self.judge(result)


NO_TRUTH = Truth(None, missing="what this shot comes to isn't known")


def broken_law(engine: ReferenceEngine, result: Result, truth: Truth) -> tuple[str, ...]:
    """Return what a run breaks of what every command asks of its engine, one sentence each."""
    asked = asked_of([(engine.name, plain_settings(engine))], Criteria())
    checks = checks_on(engine, result, truth, asked)
    return tuple(check.sentence for check in checks if check.passed is False)


def size(value: float) -> str:
    """Return a number as names of trials and scenes have it: "0", "1e-07"."""
    return f"{value:.0e}".replace("+", "") if value else "0"


def play(
    engine: ReferenceEngine,
    scene: Scene,
    record: Record = "trajectory",
    *,
    truth: Callable[[], Truth] = lambda: NO_TRUTH,
) -> Result | Verdict:
    """Run a shot; return its result, or the verdict where it has no whole one, or breaks the law.

    A motion in steps, where it is recorded, is held to what the law says of every engine whatever
    the shot, and of its `truth`, where there is one. An exact one is held to rounding by whoever
    judges it.

    Raises `UnsupportedSceneError` where the engine can't represent the scene; `EngineFailedError`
    where it fails.
    """
    result = run_engine(engine, scene, record)
    if result.status.complete:
        in_steps = record == "trajectory" and not isinstance(result.trajectory, ExactTrajectory)
        faults = broken_law(engine, result, truth()) if in_steps else ()
        return Verdict.of(scene, faults, 10.0) if faults else result
    why = f": {result.reason}" if result.reason else ""
    return Verdict.of(scene, [f"it stops at {result.rest_time:.6g} s: {result.status.value}{why}"])


@dataclass(frozen=True)
class Family:
    """One question, asked over a range.

    `name`: as on the command line, such as "grazing".
    `title`: a few words, for tables.
    `asks`: what an engine must do to survive, a sentence or two.
    `trials`: given the suite, yields the trials; those of "quick" are among those of "full", or are
        smaller ones of the same kind. Made anew at each call, always the same.
    """

    name: str
    title: str
    asks: str
    trials: Callable[[Suite], Iterable[Trial]]
