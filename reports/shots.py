"""The data of a scene for figures and the page: cases, motions, verdicts, and curves."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ghostball.model import COLLISION_KINDS, GhostballError, Phase, Scene
from ghostball.model.arrays import FloatArray
from ghostball.reports import style
from ghostball.reports.accuracy import length_text
from ghostball.reports.words import metric_of
from ghostball.validation.checks.verdict import RestError, Verdict, rest_error_standing, verdict_of
from ghostball.validation.results.store import CaseRecord, Motion, Results

MANY_BALLS = 5
"""With this many balls or more, paths of several engines are not drawn over each other."""

CHAOTIC = "too chaotic"
"""Text in place of a rest error after the horizon, where a distance says nothing about errors."""


ERROR_FLOOR = 1e-5
"""Smallest distance drawn [m].

Recorded frames are joined by straight lines, which deviate from the path of a slowing ball: for
frames of 20 ms on a common cloth by 0.01 mm if it rolls, and ten times as much if it slides.
"""

UNITS = ((1e6, "MJ"), (1e3, "kJ"), (1.0, "J"))
"""Units of energy, each with the smallest energy for which it is used [J]."""

HIGHEST = 1.8
"""Largest energy in a chart, relative to the initial energy, so that other curves are visible."""


def rest_error_text(case: CaseRecord | None) -> str:
    """Return the largest rest error as text for all tables and figures.

    It is in brackets if no limit judges it. The text is "" if there is no error, or if it would
    compare Ghostball's engine with itself.
    """
    return standing_text(case, length_text(case, metric_of(case, "rest_error_max")))


def standing_text(case: CaseRecord | None, error: str) -> str:
    """Return the text for an error of the final state, according to `rest_error_standing`."""
    return {
        RestError.JUDGED: error,
        RestError.UNJUDGED: f"({error})",
        RestError.CHAOTIC: CHAOTIC,
        RestError.OWN: "",
        RestError.NONE: "",
    }[rest_error_standing(case)]


def legend_text(verdicts: Iterable[Verdict]) -> str:
    """Return a line with the meanings of the signs of these verdicts."""
    # Two verdicts may share a sign.
    words: dict[str, list[str]] = {}
    present = set(verdicts)
    for verdict in Verdict:
        if verdict in present and verdict.symbol:
            words.setdefault(verdict.symbol, []).append(verdict.words)
    return "; ".join(f"{symbol} {' or '.join(said)}" for symbol, said in words.items())


@dataclass(frozen=True, eq=False)
class Run:
    """One engine's case in a scene, with its motion, if it ran, and its style."""

    label: str
    case: CaseRecord | None
    motion: Motion | None

    @cached_property
    def style(self) -> style.EngineStyle:
        """Style of the engine in figures."""
        return style.engine_style(self.label)

    @property
    def slides(self) -> bool:
        """Whether a ball is known to slide; recorded frames don't contain this."""
        phases = None if self.motion is None else self.motion.phases
        return phases is not None and bool(np.any(phases == Phase.SLIDING))

    @property
    def verdict(self) -> Verdict:
        """Verdict on the case."""
        return verdict_of(self.case)

    @property
    def standing(self) -> RestError:
        """Whether the rest error is judged, not judged, or meaningless."""
        return rest_error_standing(self.case)


@dataclass(frozen=True, eq=False)
class Shot:
    """One scene with the runs of all engines, in the order of the command."""

    scene: Scene
    runs: tuple[Run, ...]

    @property
    def drawn(self) -> tuple[Run, ...]:
        """The runs with a motion, Ghostball's first, so that it is drawn beneath the others."""
        moved = [run for run in self.runs if run.motion is not None]
        return tuple(sorted(moved, key=lambda run: not run.style.ours))

    @property
    def slides(self) -> bool:
        """Whether a ball is known to slide in any run."""
        return any(run.slides for run in self.drawn)

    @property
    def ours(self) -> Run | None:
        """The run of Ghostball's engine, if it has a motion, else None."""
        return next((run for run in self.drawn if run.style.ours), None)

    @property
    def truth_positions(self) -> FloatArray | None:
        """Reference rest positions, (n, 3) [m], or None if they are unknown."""
        for run in self.runs:
            if run.case is not None and run.case.truth_positions is not None:
                return run.case.truth_positions
        return None

    @property
    def truth(self) -> str | None:
        """Kind of the reference result."""
        return next((r.case.truth for r in self.runs if r.case is not None and r.case.truth), None)

    @property
    def truth_counts(self) -> dict[str, int] | None:
        """Reference collision counts by kind, or None if they are unknown."""
        return next(
            (r.case.truth_counts for r in self.runs if r.case and r.case.truth_counts), None
        )

    @property
    def end(self) -> str:
        """Name of the end of the motion: "rest" only if the balls come to rest."""
        first = next((run.case for run in self.runs if run.motion is not None), None)
        return "rest" if first is None or first.status == "rest" else "end"

    @property
    def has_many_balls(self) -> bool:
        """Whether there are too many balls to draw the paths of several engines."""
        return len(self.scene.balls) >= MANY_BALLS


def load_shot(results: Results, name: str) -> Shot:
    """Return one scene of a results folder, with its motions."""
    cases = [results.case(name, label) for label in results.labels]
    present = [case for case in cases if case is not None]
    if not present:
        raise GhostballError(
            f'{results.path}: no result for scene "{name}". Available: '
            + (", ".join(results.scene_names) or "none")
        )
    runs = tuple(
        Run(label, case, None if case is None else results.motion(case))
        for label, case in zip(results.labels, cases, strict=True)
    )
    return Shot(present[0].load_scene(), runs)


def motion_of_run(run: Run) -> Motion:
    """Return the motion of a run with a motion, such as the runs of `Shot.drawn`."""
    assert run.motion is not None
    return run.motion


def energy_scale(shot: Shot) -> tuple[float, str, float]:
    """Return a suitable unit of energy [J], its name, and the largest energy in a chart [J]."""
    # Initial energies set the scale, because an unstable simulation can reach any energy.
    start = max(largest(motion_of_run(run).energy[:1]) for run in shot.drawn)
    highest = max(largest(motion_of_run(run).energy) for run in shot.drawn)
    unit, name = next(((unit, name) for unit, name in UNITS if start >= unit), UNITS[-1])
    return unit, name, min(highest, HIGHEST * start)


def largest(values: FloatArray) -> float:
    """Return the largest finite value, or 0 if there is none."""
    return float(np.max(values[np.isfinite(values)], initial=0.0))


def collision_times(motion: Motion) -> FloatArray:
    """Return the times of all collisions in order, (k,) [s]."""
    times: FloatArray = motion.events["t"][np.isin(motion.events["kind"], COLLISION_KINDS)]
    return times


def distance_from(reference: Motion, motion: Motion) -> FloatArray:
    """Return the largest distance of a ball from an exact motion, (k,) [m], at `motion.times`.

    Distances are in the plane of the table. Between stored states, the exact motion is a cubic with
    the stored positions and velocities at both ends. This is exact up to rounding if the
    acceleration of a ball is constant or linear in time there.
    """
    if len(reference.times) == 1:  # nothing moves in the exact motion
        return _distances(motion, reference.positions[:, :, :2])
    at, span = reference.times, np.diff(reference.times)
    t = np.minimum(motion.times, at[-1])
    row = np.clip(np.searchsorted(at, t, side="right") - 1, 0, len(span) - 1)
    h = span[row][:, np.newaxis, np.newaxis]
    s = ((t - at[row]) / span[row])[:, np.newaxis, np.newaxis]
    p, v = reference.positions[:, :, :2], reference.velocities[:, :, :2]
    # Velocities jump only in the span of one ulp between the states before and after an event.
    with np.errstate(invalid="ignore", over="ignore"):  # where a motion isn't finite
        place = (
            (1.0 + 2.0 * s) * (1.0 - s) ** 2 * p[row]
            + s * (1.0 - s) ** 2 * h * v[row]
            + s**2 * (3.0 - 2.0 * s) * p[row + 1]
            - s**2 * (1.0 - s) * h * v[row + 1]
        )
    return _distances(motion, place)


def error_curves(shot: Shot) -> tuple[list[tuple[Run, FloatArray]], float]:
    """Return the distances of other engines from Ghostball's result, and the largest to show [m].

    A distance is an array (k,) [m] at the times of the engine's motion, at least `ERROR_FLOOR`.
    There are no distances if Ghostball's engine has no motion.
    """
    if shot.ours is None:
        return [], ERROR_FLOOR
    reference = motion_of_run(shot.ours)
    curves = [
        (run, np.maximum(distance_from(reference, motion_of_run(run)), ERROR_FLOOR))
        for run in shot.drawn
        if not run.style.ours
    ]
    return curves, max([10.0 * ERROR_FLOOR, *(largest(distance) for _, distance in curves)])


def _distances(motion: Motion, places: FloatArray) -> FloatArray:
    with np.errstate(invalid="ignore", over="ignore"):  # where a motion isn't finite
        distance: FloatArray = np.linalg.norm(motion.positions[:, :, :2] - places, axis=2).max(
            axis=1
        )
    return distance
