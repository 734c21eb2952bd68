"""What is stored of errors against time, as a table: each point, and what is missing and why."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal

from rich.console import Group, RenderableType
from rich.markup import escape

from benchmarks.measurements import Measurement, Record, table_of
from ghostball.reports.style import format_length, format_time

TARGETS = (1e-3, 1e-6, 1e-9)
"""Accuracies whose time is given [m]."""

LEGEND = (
    "Times are of the simulation alone, the least of all samples. A time counts where all finer "
    "steps are as near, from every phase of the step; not reached: no step that was run is. "
    "The least error is that of the worst phase of the best step. Worth it is the step up to which "
    "four times the steps at least halve the error, of the worst phase; < before a step: that is "
    "the finest one that was run, and finer ones may pay, too."
)


class PrecisionPoint(Record):
    """One engine with all of its settings on one scene.

    `scene`, `title`, `truth`: the scene, and which kind of truth it has.
    `engine`: the engine as asked for: one curve.
    `label`: the same with the step of this point.
    `step` [s]: none where the engine has no step: a point, no ladder.
    `seconds` [s]: the simulation alone: the least of all samples.
    `error`, `error_low`, `error_high` [m]: the largest distance of a ball from where it truly ends:
        median, least and greatest over the samples, each of which begins the shot at another part
        of a step.
    `same_events`: whether those balls and cushions met that meet in truth, from every phase.
    """

    scene: str
    title: str
    truth: str
    engine: str
    label: str
    step: float | None
    seconds: float
    samples: int
    error: float
    error_low: float
    error_high: float
    same_events: bool = True


class LeftOut(Record):
    """A point, or a whole curve, that is not there, and why; `step` [s] is that of a failed run."""

    scene: str
    engine: str
    why: str
    step: float | None = None


class PrecisionMeasurement(Measurement):
    """What `python -m benchmarks precision` measured."""

    kind: Literal["precision"] = "precision"
    points: tuple[PrecisionPoint, ...]
    left_out: tuple[LeftOut, ...] = ()

    @property
    def table(self) -> RenderableType:
        """Scene by scene, the time of each engine for each accuracy."""
        missing = dict.fromkeys(f"{o.scene}, {o.engine}: left out: {o.why}" for o in self.left_out)
        scenes = dict.fromkeys(point.scene for point in self.points)
        return Group(*map(self._scene, scenes), LEGEND, *map(escape, missing))

    def _scene(self, scene: str) -> RenderableType:
        points = [point for point in self.points if point.scene == scene]
        rows = []
        for engine in dict.fromkeys(point.engine for point in points):
            mine = [point for point in points if point.engine == engine]
            failed = [o.step for o in self.left_out if (o.scene, o.engine) == (scene, engine)]
            lost = [step for step in failed if step is not None]
            times = (seconds_to(target, mine, lost) for target in TARGETS)
            reached = ("not reached" if one is None else format_time(one) for one in times)
            rows.append((engine, *reached, least_error(mine), knee_text(mine)))
        heads = [
            "engine",
            *(f"to {format_length(t)}" for t in TARGETS),
            "least error (worst phase)",
            "worth it",
        ]
        title = f"[bold]{escape(f'{scene} ({points[0].truth}): {points[0].title}')}[/]"
        return table_of(heads, rows, title=title)


def seconds_to(
    target: float, points: Sequence[PrecisionPoint], lost: Sequence[float] = ()
) -> float | None:
    """Return how long an engine takes for an accuracy; None where no run was so near.

    `target` [m].
    `points`: of one engine on one scene, the longest step first.
    `lost` [s]: steps at which a run failed or stopped early: nothing coarser than these counts.

    A step that is good by luck doesn't count: all finer ones must be as good, from every phase.
    """
    seconds = []
    for point in reversed(points):
        fails_finer = point.step is not None and any(step < point.step for step in lost)
        if fails_finer or not point.error_high <= target:
            break
        seconds.append(point.seconds)
    return min(seconds, default=None)


def least_error(points: Iterable[PrecisionPoint]) -> str:
    """Return the error of the point whose worst phase is nearest, and its time: "1 nm in 24 ms".

    A median would let an engine win by a step that is good from half of all phases.
    """
    best = min(points, key=lambda point: point.error_high)
    return f"{format_length(best.error_high)} in {format_time(best.seconds)}"


def knee_of(points: Iterable[PrecisionPoint]) -> PrecisionPoint | None:
    """Return the point whose step is worth it: beyond it finer ones cost more than they mend.

    It is that of the least error of the worst phase, times the root of the steps that it takes: so
    from any coarser one four times the steps at least halve the error, and to any finer one not.

    `points`: of one engine on one scene. None where no step brought about the true events.

    Steps are counted, not timed: so the answer is the same on every machine.
    """
    steps = {one.step: one for one in points if one.step is not None and one.same_events}
    if not steps:
        return None
    return steps[min(steps, key=lambda step: (steps[step].error_high / step**0.5, -step))]


def knee_text(points: Sequence[PrecisionPoint]) -> str:
    """Return the step that is worth it, "1 ms"; "< 1 ms" where it is the finest that was run."""
    knee = knee_of(points)
    if knee is None or knee.step is None:
        return "\u2013"
    finest = min(one.step for one in points if one.step is not None)
    return f"{'< ' if knee.step == finest else ''}{format_time(knee.step)}"
