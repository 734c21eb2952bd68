"""What the figures and the report need of one scene: its cases, motions and verdicts, read once."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from engine import GhostballError, Scene
from reports import style
from validation.store import CLOSED_FORM, CaseRecord, Motion, ResultsFolder
from validation.truth import OUR_NAME

FloatArray = NDArray[np.float64]

CROWD = 5
"""From this many balls on, each engine gets its own panel: paths over each other say nothing."""


class Verdict(enum.Enum):
    """What became of one engine in one scene; the value is how reports say it."""

    PASS = "pass"
    FAIL = "fail"
    REFERENCE = "reference"
    SHOWN = "shown only"
    NOT_REPRESENTABLE = "not representable"
    UNAVAILABLE = "unavailable"
    CRASHED = "did not finish"
    MISSING = "not run"

    @property
    def symbol(self) -> str:
        """One character that stands for it, so that colour is never alone."""
        return {
            Verdict.PASS: "✓",
            Verdict.FAIL: "✗",
            Verdict.REFERENCE: "◆",
            Verdict.SHOWN: "○",
            Verdict.NOT_REPRESENTABLE: "–",
            Verdict.UNAVAILABLE: "?",
            Verdict.CRASHED: "!",
            Verdict.MISSING: "",
        }[self]


def verdict_of(case: CaseRecord | None) -> Verdict:
    """Return the verdict on a case; None is a case that the run never reached."""
    if case is None:
        return Verdict.MISSING
    if case.outcome != "ran":
        return {
            "not-representable": Verdict.NOT_REPRESENTABLE,
            "unavailable": Verdict.UNAVAILABLE,
            "failed": Verdict.CRASHED,
        }[case.outcome]
    if case.passed is None:
        return Verdict.REFERENCE if case.checks else Verdict.SHOWN
    return Verdict.PASS if case.passed else Verdict.FAIL


def rest_verdict_of(case: CaseRecord | None) -> Verdict:
    """Return what the checks on the rest error alone say; SHOWN where none limits it.

    A case may pass by its energy and counts while its rest error, past what can be predicted, is
    free: a figure of rest errors must not call such a number passed.
    """
    verdicts = [
        check.passed
        for check in (case.checks if case is not None else ())
        if check.metric.startswith("rest_error") and check.passed is not None
    ]
    if not verdicts:
        return Verdict.SHOWN
    return Verdict.PASS if all(verdicts) else Verdict.FAIL


def is_own_measure(case: CaseRecord) -> bool:
    """Whether a rest error of this case compares our engine with itself, and proves nothing."""
    return case.engine == OUR_NAME and case.truth != CLOSED_FORM


@dataclass(frozen=True, eq=False)
class Run:
    """One engine's case in a scene, with its motion where it ran, and its look."""

    label: str
    case: CaseRecord | None
    motion: Motion | None

    @cached_property
    def style(self) -> style.EngineStyle:
        """How the engine is drawn."""
        return style.engine_style(self.label)

    @property
    def verdict(self) -> Verdict:
        """What became of it."""
        return verdict_of(self.case)

    def metric(self, name: str) -> float | None:
        """Return a metric of the case, or None where there is no finite number."""
        value = self.case.metrics.get(name) if self.case is not None else None
        return float(value) if value is not None and np.isfinite(value) else None

    @property
    def rest_verdict(self) -> Verdict:
        """What the checks on the rest error alone say; SHOWN where none limits it."""
        return rest_verdict_of(self.case)

    def limit(self, metric: str) -> float | None:
        """Return the most that a metric may be, or None where nothing limits it from above."""
        if self.case is not None:
            for check in self.case.checks:
                if check.metric == metric and check.limit_kind in ("at_most", "equals"):
                    return float(check.limit)
        return None


@dataclass(frozen=True, eq=False)
class Shot:
    """One scene with the runs of all engines, in the order that the suite was asked for."""

    scene: Scene
    runs: tuple[Run, ...]

    @property
    def drawn(self) -> tuple[Run, ...]:
        """The runs that have a motion, ours first: it lies beneath."""
        moved = [run for run in self.runs if run.motion is not None]
        return tuple(sorted(moved, key=lambda run: not run.style.ours))

    @property
    def ours(self) -> Run | None:
        """Our engine's run, where it has a motion."""
        return next((run for run in self.drawn if run.style.ours), None)

    @property
    def truth_positions(self) -> FloatArray | None:
        """Where the balls rest in truth, (n, 3) [m], or None where nothing is known."""
        for run in self.runs:
            if run.case is not None and run.case.truth_positions is not None:
                return run.case.truth_positions
        return None

    @property
    def truth(self) -> str | None:
        """What the truth of this scene is."""
        return next((r.case.truth for r in self.runs if r.case is not None and r.case.truth), None)

    @property
    def crowded(self) -> bool:
        """Whether each engine needs a panel of its own."""
        return len(self.scene.balls) >= CROWD


def load_shot(results: ResultsFolder, name: str) -> Shot:
    """Read one scene of a results folder with its motions.

    Raises
    ------
    GhostballError
        Where the folder has no case of that scene, or a motion can't be read.
    """
    cases = [results.case(name, label) for label in results.labels]
    present = [case for case in cases if case is not None]
    if not present:
        raise GhostballError(
            f'{results.path}: no case of scene "{name}". It holds: '
            + (", ".join(results.scene_names) or "none")
        )
    runs = tuple(
        Run(label, case, None if case is None else results.motion(case))
        for label, case in zip(results.labels, cases, strict=True)
    )
    return Shot(present[0].load_scene(), runs)
