"""What a notebook shows of `Scene` and `Result`: a small SVG of the scene, or of what became of it.

Text alone, so that no matplotlib is loaded for it. The figures beside this module show more.
Importing this module registers both pictures with the model.
"""

from __future__ import annotations

from html import escape

import numpy as np

from ghostball.model import Result, Scene
from ghostball.model.arrays import FloatArray
from ghostball.model.views import VIEWS

PIXELS = 640.0
"""Of the longer side."""

MARGIN = 0.06
"""Around the table, or around the balls where there is none [m]."""

TIMES = 200
"""At how many instants the balls are followed, beside those of the events."""

AIM = 0.15
"""What the line of a moving ball shows: how far it would go in this time [s]."""

# From the cue ball to the eight; then again, since every ball has its name beside it.
COLOURS = (
    "white",
    "gold",
    "cornflowerblue",
    "tomato",
    "plum",
    "orange",
    "lightgreen",
    "tan",
    "black",
)


def picture(scene: Scene, path: FloatArray | None = None) -> str:
    """Return the table and its balls, seen from above, as SVG.

    `path` (k, n, 3) [m] is where the balls were at k instants, the last of them their end: they are
    drawn there, and as rings where they began. What isn't finite is left out.
    """
    moved = scene.positions[np.newaxis] if path is None else path
    xy = np.concatenate([scene.positions[np.newaxis], moved])[:, :, :2]
    corners = [
        xy[np.isfinite(xy).all(axis=2)] - size for size in (scene.radii.max(), -scene.radii.max())
    ]
    if scene.table is not None:
        corners.append(np.array([[0.0, 0.0], [scene.table.length, scene.table.width]]))
    points = np.concatenate(corners)
    low, high = points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN
    scale = PIXELS / float(max(high - low))
    width, height = (high - low) * scale

    def at(x: float, y: float) -> tuple[float, float]:
        return (x - low[0]) * scale, (high[1] - y) * scale

    def circle(centre: FloatArray, radius: float, look: str) -> str:
        x, y = at(*centre)
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius * scale:.1f}" {look}/>'

    def line(through: FloatArray, look: str) -> str:
        points = " ".join("{:.1f},{:.1f}".format(*at(*point)) for point in through)
        return f'<polyline points="{points}" fill="none" {look}/>'

    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        'font-family="sans-serif" font-size="11">',
        f"<title>{escape(scene.title or scene.name)}</title>",
        '<rect width="100%" height="100%" fill="#2f5d4a"/>',
    ]
    if scene.table is not None:
        x, y = at(0.0, scene.table.width)
        size = f'width="{scene.table.length * scale:.1f}" height="{scene.table.width * scale:.1f}"'
        if scene.table.is_rectangle:
            parts.append(f'<rect x="{x:.1f}" y="{y:.1f}" {size} fill="#3d7a62" stroke="#23382f"/>')
        else:
            shape = " ".join("{:.1f},{:.1f}".format(*at(*point)) for point in scene.table.drawn)
            parts.append(f'<polygon points="{shape}" fill="#3d7a62" stroke="#23382f"/>')
        for hole in scene.table.holes:
            parts.append(circle(np.array(hole.centre), hole.radius, 'fill="#111"'))
        for post in scene.table.posts:
            parts.append(circle(np.array(post.centre), post.radius, 'fill="#8c9a91"'))
    names = []
    for i, ball in enumerate(scene.balls):
        colour, start = COLOURS[i % len(COLOURS)], xy[0, i]
        track = xy[:, i][np.isfinite(xy[:, i]).all(axis=1)]
        if path is None:
            aim = np.array([start, start + AIM * scene.velocities[i, :2]])
            parts.append(line(aim, f'stroke="{colour}" stroke-width="2" stroke-dasharray="4 2"'))
        else:
            parts.append(line(track, f'stroke="{colour}" opacity="0.7"'))
            parts.append(circle(start, ball.radius, f'stroke="{colour}" fill="none"'))
        parts.append(circle(track[-1], ball.radius, f'fill="{colour}" stroke="#111"'))
        x, y = at(*(track[-1] + 1.1 * ball.radius))
        names.append(f'<text x="{x:.1f}" y="{y:.1f}" fill="#fff">{escape(ball.id)}</text>')
    return "".join((*parts, *names, "</svg>"))


def ended(result: Result) -> str:
    """Return how a shot ended, and the paths of its balls, as HTML."""
    path = result.rest_positions[np.newaxis]
    if result.trajectory is not None:
        times = np.linspace(0.0, result.rest_time, TIMES)
        if result.events is not None:  # where the paths have their corners
            times = np.union1d(times, result.events["t"])
        path = np.concatenate([result.sample(times).positions, path])
    counts = ", ".join(f"{kind} {count}" for kind, count in result.collision_counts.items())
    status = result.status.name.lower()
    text = f"{result.engine}, {status} at t = {result.rest_time:.6g} s; {counts}"
    drawn = picture(result.scene, path)
    return f"<figure>{drawn}<figcaption>{escape(text)}</figcaption></figure>"


VIEWS.update({Scene: picture, Result: ended})
