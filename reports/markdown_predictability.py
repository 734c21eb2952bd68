"""The report's section on how far shots can be predicted."""

from __future__ import annotations

from ghostball.reports import style
from ghostball.reports.markdown_parts import table_of
from ghostball.validation.diagnose.predictability import Predictability, predictability_in
from ghostball.validation.results.store import CaseRecord, Results

_MEANS = """\
*Growth* is what rounding the state once at the start and at each event becomes by the end, over
2⁻⁵³: root mean square of the ball that goes farthest, by the tangent map of our engine's own
trajectory. The *horizon* is when 32 roundings of it may come to {tolerance}; past it, double
precision can't say where the balls are. Nor is there a
derivative after one ball has several collisions at one instant, or in sustained contact: the
horizon is there at the latest. How nearly another ball would have met, `ghostball explain` says.\
"""

_OWN_MEANS = """\
Each engine errs by its own size: one that steps sees contacts up to a step late, one that lands on
them stops 1e-10 m short, an exact one rounds. From this instant on, errors of that size may take
the shot another course, and no error of how it ends is printed, unless a criterion asks for it.\
"""


def predictability_section(results: Results) -> list[str]:
    """Return the parts of the section; none where nothing is stored."""
    shots = predictability_in(results)
    if not shots:
        return []
    parts = [
        _MEANS.format(tolerance=style.format_length(shots[0].tolerance)),
        table_of(
            ["scene", "growth [m]", "horizon"],
            [_row(shot) for shot in shots],
        ),
    ]
    return parts + _horizons(results)


def _horizons(results: Results) -> list[str]:
    """Return the table of engines that can't be expected to play a shot to its end."""
    labels = [
        label
        for label in results.labels
        if any(case.label == label and case.horizon is not None for case in results.cases)
    ]
    rows = []
    for scene in results.scene_names:
        cases = [results.case(scene, label) for label in labels]
        if any(case is not None and case.horizon is not None for case in cases):
            rows.append([scene, *map(_own_horizon, cases)])
    if not rows:
        return []
    return [_OWN_MEANS, table_of(["scene", *(f"`{label}`" for label in labels)], rows)]


def _own_horizon(case: CaseRecord | None) -> str:
    if case is None or case.outcome != "ran":
        return "–"
    return "to its end" if case.horizon is None else style.format_time(case.horizon)


def _row(shot: Predictability) -> list[str]:
    end = shot.growth[-1]
    return [
        shot.scene,
        "none" if end != end else f"{end:.2g}",  # noqa: PLR0124 - nan: there is no derivative
        horizon_text(shot),
    ]


def horizon_text(shot: Predictability) -> str:
    """Return when a shot can't be predicted any more."""
    if shot.horizon is None:
        return f"past its end ({style.format_time(shot.rest_time)})"
    why = "" if shot.ends == "growth" else f" ({shot.ends})"
    return f"{style.format_time(shot.horizon)} of {style.format_time(shot.rest_time)}{why}"
