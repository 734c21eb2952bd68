"""Functions for several pictures: load a stored shot, sample a motion, write beside a point."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ghostball.model import GhostballError, SampledTrajectory
from ghostball.reports import style
from ghostball.reports.shots import Run, Shot, load_shot
from ghostball.validation.results.store import Motion, Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def our_shot(results: Results, name: str) -> tuple[Shot, Run]:
    """Return a stored shot, and its run on Ghostball's engine, with a motion.

    Raises `GhostballError` if the results have none.
    """
    if name in results.scene_names:
        shot = load_shot(results, name)
        if shot.ours is not None:
            return shot, shot.ours
    raise GhostballError(
        f'{results.path}: a picture needs the motion of scene "{name}" on Ghostball\'s engine, but '
        "the results have none. Run the full suite on every engine"
    )


def recorded(motion: Motion, balls: slice = slice(None)) -> SampledTrajectory:
    """Return a stored motion of some balls as a trajectory, linear between the stored times."""
    return SampledTrajectory(
        motion.times,
        motion.positions[:, balls],
        motion.velocities[:, balls],
        motion.angular_velocities[:, balls],
    )


def write_at(
    axes: Axes,
    at: tuple[float, float],
    text: str,
    offset: tuple[int, int],
    end: str,
    colour: str = style.GREY,
) -> None:
    """Write a text beside a point.

    `offset`: distance from the point [points].
    `end`: the end of the text at the point, "left" or "right".
    """
    axes.annotate(
        text,
        at,
        xytext=offset,
        textcoords="offset points",
        ha=end,
        color=colour,
        fontsize=8.5,
    )
