"""What the figures and the report need of one scene: its cases, motions and verdicts, read once."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ghostball.model import GhostballError, Phase, Scene
from ghostball.model.arrays import FloatArray
from ghostball.reports import style
from ghostball.validation.checks.verdict import (
    RestError,
    Verdict,
    rest_error_standing,
    verdict_of,
)
from ghostball.validation.results.store import CaseRecord, Motion, Results

MANY_BALLS = 5
"""From this many balls on no paths are drawn over each other: they would say nothing."""

CHAOTIC = "(unpredictable)"
"""Stands for a rest error where an engine's errors may have made another shot: it is no error."""


def rest_error(case: CaseRecord | None) -> float | None:
    """Return the largest rest error of a case [m], or None where it has no finite one."""
    value = None if case is None else case.metrics.get("rest_error_max")
    return float(value) if value is not None and math.isfinite(value) else None


def rest_error_text(case: CaseRecord | None) -> str:
    """Return the largest rest error as every table and figure shows it.

    In brackets where no limit judges it; "" where there is none, or it would compare our engine
    with itself.
    """
    return standing_text(case, style.format_length(rest_error(case)))


def standing_text(case: CaseRecord | None, error: str) -> str:
    """Return an error of the rest state, formatted, as `rest_error_standing` says to show it."""
    return {
        RestError.JUDGED: error,
        RestError.UNJUDGED: f"({error})",
        RestError.CHAOTIC: CHAOTIC,
        RestError.OWN: "",
        RestError.NONE: "",
    }[rest_error_standing(case)]


def legend_text(verdicts: Iterable[Verdict]) -> str:
    """Return one line that says what the signs of these verdicts and the brackets mean."""
    # Two verdicts may share a sign.
    words: dict[str, list[str]] = {}
    present = set(verdicts)
    for verdict in Verdict:
        if verdict in present and verdict.symbol:
            words.setdefault(verdict.symbol, []).append(verdict.words)
    return "; ".join(f"{symbol} {' or '.join(said)}" for symbol, said in words.items())


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
    def slides(self) -> bool:
        """Whether its motion says that a ball slides; frames don't say."""
        phases = None if self.motion is None else self.motion.phases
        return phases is not None and bool(np.any(phases == Phase.SLIDING))

    @property
    def verdict(self) -> Verdict:
        """What became of it."""
        return verdict_of(self.case)

    def metric(self, name: str) -> float | None:
        """Return a metric of the case, or None where there is no finite number."""
        value = self.case.metrics.get(name) if self.case is not None else None
        return float(value) if value is not None and np.isfinite(value) else None

    @property
    def standing(self) -> RestError:
        """What its rest error is worth."""
        return rest_error_standing(self.case)


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
    def slides(self) -> bool:
        """Whether some path has a part that is known to be sliding."""
        return any(run.slides for run in self.drawn)

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
    def truth_counts(self) -> dict[str, int] | None:
        """True collision counts by kind, or None where nothing is known."""
        return next(
            (r.case.truth_counts for r in self.runs if r.case and r.case.truth_counts), None
        )

    @property
    def end(self) -> str:
        """What the end of the motion is called: "rest" only where the balls come to rest."""
        first = next((run.case for run in self.runs if run.motion is not None), None)
        return "rest" if first is None or first.status == "rest" else "end"

    @property
    def has_many_balls(self) -> bool:
        """Whether there are too many balls for paths over each other."""
        return len(self.scene.balls) >= MANY_BALLS


def load_shot(results: Results, name: str) -> Shot:
    """Read one scene of a results folder with its motions."""
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
