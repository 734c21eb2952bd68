"""Draw a table, its cushions and balls to scale, for all pictures of shots."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ghostball.model import CUSHIONS, Scene, Table
from ghostball.model.arrays import FloatArray
from ghostball.model.scene.sides import side_of
from ghostball.reports import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import EllipseCollection

View = tuple[float, float, float, float]
"""Left, right, bottom and top edge of a picture [m]."""

CUSHION_DEPTH = 0.045
"""Depth of a cushion [m], about the depth of a real cushion."""


def view_of(scene: Scene, *positions: FloatArray, needed: FloatArray | None = None) -> View:
    """Return the part of the cloth to show: the table, and the positions near it.

    `*positions` (..., 3) float64 [m]: centres to show, if they aren't too far away; infinite values
        and NaN are ignored.
    `needed` (n, 3) float64 [m]: centres to show, however far away they are.
    """
    radius = float(scene.radii.max())
    low, high = _bounds(radius, scene.positions, *positions)
    near_low, near_high = _bounds(radius, scene.positions if needed is None else needed)
    table = scene.table
    if table is not None:
        # A ball that an engine lost a kilometre away must not shrink the table to a dot.
        reach = np.array([table.length, table.width])
        holes = (hole.radius - min(hole.centre) for hole in table.holes)
        margin = max([1.4 * CUSHION_DEPTH, *holes])
        near_low = np.minimum(near_low, -margin)
        near_high = np.maximum(near_high, reach + margin)
        low = np.clip(low, np.minimum(near_low, -0.25 * reach), near_low)
        high = np.clip(high, near_high, np.maximum(near_high, 1.25 * reach))
    else:
        # A straight shot on an unbounded cloth would be a line without height.
        size = high - low
        pad = np.maximum(0.04 * size.max(), (0.3 * size[::-1] - size) / 2.0)
        low, high = low - pad, high + pad
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def _bounds(radius: float, *positions: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two opposite corners, (2,) each [m], of a box around all centres with a margin."""
    xy = np.concatenate([p.reshape(-1, p.shape[-1])[:, :2] for p in positions])
    xy = xy[np.isfinite(xy).all(axis=1)]
    return xy.min(axis=0) - 2.0 * radius, xy.max(axis=0) + 2.0 * radius


def aspect_of(view: View) -> float:
    """Return the height of a view divided by its width."""
    left, right, bottom, top = view
    return (top - bottom) / (right - left)


def draw_table(axes: Axes, scene: Scene, view: View, *, ticks: bool = True) -> None:
    """Draw cloth and cushions, and set equal aspect and limits.

    A side without a cushion is dashed: the cloth continues.
    """
    from matplotlib.patches import Rectangle  # noqa: PLC0415

    left, right, bottom, top = view
    table = scene.table
    axes.set_facecolor(style.CLOTH if table is None else "white")
    if table is not None and not table.is_rectangle:
        _draw_shaped(axes, table)
    elif table is not None:
        size, depth = (table.length, table.width), CUSHION_DEPTH
        axes.add_patch(Rectangle((0, 0), *size, facecolor=style.CLOTH, zorder=0))
        for name in CUSHIONS:
            side = side_of(name, *size)
            if name in table.cushions:
                corners = np.array([*side.ends(depth), *side.ends(depth, depth)])
                low, high = corners.min(axis=0), corners.max(axis=0)
                axes.add_patch(
                    Rectangle(low, *(high - low), facecolor=style.CUSHION, linewidth=0, zorder=0.5)
                )
            else:
                edge = np.transpose(side.ends())
                axes.plot(*edge, color=style.GREY, linestyle=":", linewidth=1, zorder=0.5)
    for post in () if table is None else table.posts:
        draw_ball(axes, np.array(post.centre), post.radius, facecolor=style.CUSHION, zorder=0.6)
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    axes.set_aspect("equal", anchor="N")
    for spine in axes.spines.values():
        spine.set_visible(False)
    if ticks:
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
        _few_ticks(axes, view)
    else:
        axes.set_xticks([])
        axes.set_yticks([])


def _draw_shaped(axes: Axes, table: Table) -> None:
    """Draw a table that isn't a plain rectangle: its cushions, its cloth, and its holes."""
    from matplotlib.patches import Polygon, Rectangle  # noqa: PLC0415

    depth = CUSHION_DEPTH
    size = (table.length + 2.0 * depth, table.width + 2.0 * depth)
    axes.add_patch(Rectangle((-depth, -depth), *size, facecolor=style.CUSHION, zorder=0))
    axes.add_patch(
        Polygon(np.array(table.drawn_outline), facecolor=style.CLOTH, linewidth=0, zorder=0.4)
    )
    for hole in table.holes:
        draw_ball(axes, np.array(hole.centre), hole.radius, facecolor=style.BLACK, zorder=0.5)


def _few_ticks(axes: Axes, view: View) -> None:
    """Set as many ticks as fit: a narrow strip gets two or three."""
    from matplotlib.ticker import MaxNLocator  # noqa: PLC0415

    aspect = aspect_of(view)
    axes.xaxis.set_major_locator(MaxNLocator(max(2, min(6, round(6 / max(1.0, aspect))))))
    axes.yaxis.set_major_locator(MaxNLocator(max(2, min(5, round(8 * aspect)))))


def draw_ball(axes: Axes, centre: FloatArray, radius: float, **look: Any) -> None:
    """Draw one ball as a disc to scale; `look` goes to matplotlib's Circle."""
    from matplotlib.patches import Circle  # noqa: PLC0415

    if np.isfinite(centre[:2]).all():
        axes.add_patch(Circle((float(centre[0]), float(centre[1])), radius, **look))


def draw_discs(
    axes: Axes, centres: FloatArray, radii: FloatArray, **look: Any
) -> EllipseCollection:
    """Draw all balls to scale as one artist and return it; one artist per ball is much slower."""
    from matplotlib.collections import EllipseCollection  # noqa: PLC0415

    discs = EllipseCollection(
        2.0 * radii,
        2.0 * radii,
        np.zeros(len(radii)),
        units="xy",
        offsets=centres[:, :2],
        offset_transform=axes.transData,
        linewidths=1.0,
        **look,
    )
    axes.add_collection(discs, autolim=False)
    return discs


def draw_scale_bar(axes: Axes, view: View, length: float, text: str) -> None:
    """Draw a scale bar of the given length [m] at the lower left, away from pockets."""
    from matplotlib.patheffects import withStroke  # noqa: PLC0415

    left, right, bottom, top = view
    x = left + 0.08 * (right - left)
    y = bottom + 0.15 * (top - bottom)
    axes.plot(
        [x, x + length], [y, y], color=style.BLACK, linewidth=2, solid_capstyle="butt", zorder=7
    )
    label = axes.text(
        x, y + 0.015 * (top - bottom), text, fontsize=7.5, va="bottom", ha="left", zorder=7
    )
    label.set_path_effects([withStroke(linewidth=2.5, foreground=style.CLOTH)])
