"""What the pictures share: a stored shot with our engine's motion, and words beside a point."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ghostball.model import GhostballError, SampledTrajectory
from ghostball.reports import style
from ghostball.reports.shots import Run, Shot, load_shot
from ghostball.validation.results.store import Motion, Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def our_shot(results: Results, name: str) -> tuple[Shot, Run]:
    """Return a stored scene and our engine's run of it, which has a motion."""
    if name in results.scene_names:
        shot = load_shot(results, name)
        if shot.ours is not None:
            return shot, shot.ours
    raise GhostballError(
        f'{results.path}: a picture needs our engine\'s motion in scene "{name}", which these '
        "results lack. Run the full suite on every engine"
    )


def recorded(motion: Motion, balls: slice = slice(None)) -> SampledTrajectory:
    """Return a stored motion of some balls, with straight lines between its instants."""
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
    """Write a text at a point, `offset` points from it; `end` is which end of the text is there."""
    axes.annotate(
        text,
        at,
        xytext=offset,
        textcoords="offset points",
        ha=end,
        color=colour,
        fontsize=8.5,
    )
