"""The metrics: name, unit and meaning of each, and the reference that it is compared with.

`metrics` computes them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from fnmatch import fnmatchcase

from ghostball.model import GhostballError
from ghostball.validation.results.records import ACCURACY_KINDS
from ghostball.validation.truth.scene_truth import TruthPart


class MetricError(GhostballError, ValueError):
    """A choice of metrics that matches no known metric."""


@dataclass(frozen=True)
class Metric:
    """A row of the metric table.

    `name`, `unit`: SI; "1" is a pure number, "class" a class of accuracy.
    `meaning`: one line.
    `compares`: the part of the reference that it is compared with; None: it needs no reference.
    `outcome`: True if an upper limit, or an exact value, judges rest positions, the rest time
        or the collisions of the whole shot. Energy, overlaps and the first collisions alone don't
        judge them: these can be right in a shot with a wrong end.
    `to_the_end`: True for an error of the end of the shot, which has no meaning after the engine's
        horizon.
    `on_demand`: True if it is measured only when a limit or the user names it, because it concerns
        a special kind of shot or needs a second shot.
    """

    name: str
    unit: str
    meaning: str
    compares: TruthPart | None = None
    outcome: bool = False
    to_the_end: bool = False
    on_demand: bool = False


METRICS: dict[str, Metric] = {
    metric.name: metric
    for metric in (
        Metric(
            "rest_error_max",
            "m",
            "largest distance of a ball from where it should end",
            "rest",
            outcome=True,
            to_the_end=True,
        ),
        Metric(
            "rest_error_rms",
            "m",
            "root mean square of those distances over the balls",
            "rest",
            outcome=True,
            to_the_end=True,
        ),
        Metric(
            "rest_error_ulps",
            "1",
            "largest distance over what rounding the scene's numbers once would cause",
            "conditioning",
            outcome=True,
            to_the_end=True,
        ),
        Metric(
            "rest_time_error",
            "s",
            "difference of the time when the last ball rests",
            "time",
            outcome=True,
            to_the_end=True,
        ),
        Metric(
            "rest_time_error_ulps",
            "1",
            "that difference over what rounding the scene's numbers once would cause",
            "conditioning",
            outcome=True,
            to_the_end=True,
        ),
        Metric("ball_ball_count", "1", "collisions between balls", outcome=True),
        Metric("ball_cushion_count", "1", "collisions with cushions", outcome=True),
        Metric("collision_count", "1", "collisions of both kinds", outcome=True),
        Metric(
            "ball_ball_count_error",
            "1",
            "difference of the ball-ball count",
            "events",
            outcome=True,
            to_the_end=True,
        ),
        Metric(
            "ball_cushion_count_error",
            "1",
            "difference of the ball-cushion count",
            "events",
            outcome=True,
            to_the_end=True,
        ),
        Metric(
            "matching_events",
            "1",
            "leading collisions that agree with the true sequence (kind and balls)",
            "events",
            outcome=True,
        ),
        Metric(
            "first_divergence_time", "s", "when the sequences of collisions first differ", "events"
        ),
        Metric(
            "graded_until",
            "s",
            "how far the run is held against the proof: to its end, or where errors of rounding "
            "have grown visible",
            "proof",
        ),
        Metric("graded_events", "1", "proved events until then that are looked for", "proof"),
        Metric(
            "events_missing",
            "1",
            "proved events of any kind that were not found, up to where the shot can be predicted; "
            "from where a ball's own order of events differs on, all of its",
            "proof",
        ),
        Metric(
            "events_invented",
            "1",
            "found events without a proved one in their place, up to where the shot can be "
            "predicted",
            "proof",
        ),
        Metric(
            "event_time_error",
            "s",
            "largest time error of the run's events that match a certified event, up to the "
            "engine's horizon",
            "proof",
        ),
        Metric(
            "phase_time_error",
            "s",
            "largest time error of the ends of slides and rolls up to the horizon, for a "
            "time-stepping engine that reports them; a missing end is taken at its ball's "
            "nearest collision",
            "proof",
        ),
        Metric(
            "event_time_error_ulps",
            "1",
            "largest error of an event's time up to there, in spacings of doubles at that time",
            "proof",
        ),
        Metric(
            "event_time_factor",
            "1",
            "largest error of an event time up to the horizon, in units of the error that one "
            "rounding per event would cause",
            "proof",
        ),
        Metric(
            "rest_time_factor",
            "1",
            "error of the time at which the last ball stops, in units of the error that one "
            "rounding per event would cause",
            "proof",
            outcome=True,
            to_the_end=True,
        ),
        Metric(
            "quality_factor",
            "1",
            "largest position error at the horizon, in units of the error that one rounding per "
            "event would cause",
            "proof",
            outcome=True,
        ),
        Metric(
            "path_error",
            "m",
            "largest position error of a ball in the plane, up to the horizon; positions between "
            "the two times of a matching event aren't compared",
            "proof",
        ),
        Metric(
            "early_path_error",
            "m",
            "largest position error before the first contact of the shot, for a time-stepping "
            "engine",
            "proof",
        ),
        Metric(
            "path_factor",
            "1",
            "largest error of a ball's position, velocity or spin up to the horizon, in units of "
            "the error that one rounding per event would cause; nothing is compared between the "
            "two times of a matching event",
            "proof",
        ),
        Metric(
            "energy_difference_max",
            "1",
            "largest deviation from the reference energy, divided by the initial energy; energies "
            "between the two times of a matching event aren't compared",
            "energy",
        ),
        Metric("energy_difference_time", "s", "time of `energy_difference_max`", "energy"),
        Metric(
            "energy_difference_factor",
            "1",
            "largest energy error up to the horizon for rounding errors, in units of the error "
            "that one rounding per event would cause",
            "proof",
        ),
        Metric(
            "energy_drift",
            "1",
            "largest change of energy where it should hold, over the initial energy",
        ),
        Metric(
            "energy_rise",
            "1",
            "largest rise of energy above the least before it, at each impact and each frame, over "
            "the initial energy; in a step with an impact, above what the cloth leaves",
        ),
        Metric("overlap_max", "m", "largest overlap of two balls in the recorded motion"),
        Metric(
            "cushion_overlap_max",
            "m",
            "largest overlap of a ball and a cushion, a jaw or a post in the recorded motion",
            on_demand=True,
        ),
        Metric(
            "momentum_drift",
            "1",
            "largest change of the balls' total momentum in the plane, divided by the largest "
            "sum of their momenta",
            on_demand=True,
        ),
        Metric(
            "pocketed_count", "1", "balls that fall into a pocket", outcome=True, on_demand=True
        ),
        Metric("event_count", "1", "events of any kind", on_demand=True),
        Metric(
            "contact_steps",
            "1",
            "short steps of the engine along resting contacts, if it counts them",
            on_demand=True,
        ),
        Metric(
            "unsolved",
            "1",
            "resting contacts and simultaneous impacts that the engine reports as unsolved",
            on_demand=True,
        ),
        Metric(
            "mirror_error",
            "m",
            "largest distance between the mirrored final positions and those of the mirrored "
            "shot, with x and y swapped and the balls in reverse order",
            on_demand=True,
        ),
        Metric(
            "reversal_error",
            "m",
            "largest distance from the start after the shot is simulated backwards from its end, "
            "unless rounding alone prevents the return",
            on_demand=True,
        ),
        Metric(
            "reversal_factor",
            "1",
            "`reversal_error` in units of the error that one rounding per event would cause on "
            "the way back",
            on_demand=True,
        ),
        Metric("wall_time", "s", "run time of the simulation alone, one sample"),
        Metric(
            "accuracy",
            "class",
            f"how right the run is, from the best class: {', '.join(ACCURACY_KINDS)}",
            "rest",
            outcome=True,
        ),
    )
}
"""Every metric by name, in the order of reports."""

USUAL: tuple[str, ...] = tuple(name for name, metric in METRICS.items() if not metric.on_demand)
"""The metrics that are measured for every shot."""


def choose_metrics(patterns: Sequence[str]) -> tuple[str, ...]:
    """Return the metrics that match the patterns, in the order of `METRICS`, each once.

    `patterns`: names, or patterns with `*`, `?` and `[...]` such as "rest_error_*".

    Raises `MetricError` if there is no pattern, or if a pattern matches no metric.
    """
    if not patterns:
        raise MetricError("`metrics` must name at least one metric, got none")
    found = {pattern: [n for n in METRICS if fnmatchcase(n, pattern)] for pattern in patterns}
    for pattern, names in found.items():
        if not names:
            close = get_close_matches(pattern, METRICS, n=1)
            hint = f"Did you mean `{close[0]}`? " if close else ""
            raise MetricError(
                f"`metrics` must name known metrics, got {pattern!r}. {hint}"
                f"Known: {', '.join(METRICS)}"
            )
    return tuple(name for name in METRICS if any(name in names for names in found.values()))
