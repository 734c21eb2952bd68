"""The report's section on how far shots can be predicted."""

from __future__ import annotations

from pathlib import PurePosixPath

from reports import style
from reports.markdown_parts import figure_link, one_line, table_of
from validation.predictability import Predictability, load_predictability
from validation.store import ResultsFolder

_MEANS = """\
*Growth* is what rounding the state once at the start and at each event becomes by the end, over
2⁻⁵³: root mean square of the ball that goes farthest, by the tangent map of our engine's own
trajectory. The *horizon* is when 32 roundings of it may come to {tolerance}; past it, double
precision can't say where the balls are, and no error of a position is printed. Nor is there a
derivative after one ball has several collisions at one instant, or in sustained contact: the
horizon is there at the latest. The *nearest other course* is the smallest relative change of the
first state (positions by the extent of the scene, velocities by the speed) after which other balls
meet, or in another order. Where 32 roundings reach it, the scene is **fragile**: the last bits of
its numbers decide its course.\
"""

CAPTION = "Shots that begin almost alike part exponentially, as the tangent map says"


def predictability_section(results: ResultsFolder, figure: PurePosixPath | None) -> list[str]:
    """Return the parts of the section; none where nothing is stored.

    Parameters
    ----------
    results : ResultsFolder
    figure : path or None
        Of the shots that begin almost alike.
    """
    known = load_predictability(results.path)
    shots = [known[name] for name in results.scene_names if name in known]
    if not shots:
        return []
    parts = [
        "## How far the shots can be predicted",
        _MEANS.format(tolerance=style.format_length(shots[0].tolerance)),
        table_of(
            ["scene", "growth [m]", "horizon", "nearest other course", "by a change of"],
            [_row(shot) for shot in shots],
        ),
    ]
    if figure is not None:
        parts.append(figure_link(CAPTION, figure))
    return parts


def _row(shot: Predictability) -> list[str]:
    end = shot.growth[-1]
    nearest = one_line(shot.nearest) or "none"
    return [
        shot.scene,
        "none" if end != end else f"{end:.2g}",  # noqa: PLR0124 - nan: there is no derivative
        horizon_text(shot),
        f"**fragile:** {nearest}" if shot.fragile else nearest,
        f"{shot.bifurcations[0].relative:.1e}" if shot.bifurcations else "–",
    ]


def horizon_text(shot: Predictability) -> str:
    """Return when a shot can't be predicted any more."""
    if shot.horizon is None:
        return f"past its end ({style.format_time(shot.rest_time)})"
    why = "" if shot.ends == "growth" else f" ({shot.ends})"
    return f"{style.format_time(shot.horizon)} of {style.format_time(shot.rest_time)}{why}"
