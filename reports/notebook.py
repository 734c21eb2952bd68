"""Pictures of `Scene` and `Result` in notebooks: a small SVG of the scene, or of its simulation.

The SVG is written as text, without loading matplotlib; the package `figures` draws larger pictures.
Importing this module registers both pictures with the model.
"""

from __future__ import annotations

import numpy as np
from jinja2 import Template
from markupsafe import Markup

from ghostball.model import Result, Scene
from ghostball.model.arrays import FloatArray
from ghostball.model.views import VIEWS
from ghostball.reports.templating import templates_of

PIXELS = 640.0
"""Length of the longer side of a picture."""

MARGIN = 0.06
"""Margin around the table, or around the balls if there is no table [m]."""

TIMES = 200
"""Number of points of a path, in addition to the points at events."""

AIM = 0.15
"""A moving ball has a line as long as the distance that the ball would move in this time [s]."""

# Colours from the cue ball to the eight ball. They repeat; every ball has its name beside it.
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

    `path` (k, n, 3) [m]: positions of the balls at k times. Balls are drawn at their last
        positions, with rings at the initial positions. Positions that aren't finite are left out.
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
    balls = []
    for i, ball in enumerate(scene.balls):
        track = xy[:, i][np.isfinite(xy[:, i]).all(axis=1)]
        aim = xy[0, i] + AIM * scene.velocities[i, :2]
        balls.append((ball, COLOURS[i % len(COLOURS)], xy[0, i], track, aim))
    return _template("scene.svg").render(
        scene=scene,
        table=scene.table,
        balls=balls,
        moved=path is not None,
        low=low,
        high=high,
        scale=PIXELS / float(max(high - low)),
    )


def ended(result: Result) -> str:
    """Return the end of a shot in words, and the paths of its balls, as HTML."""
    path = result.rest_positions[np.newaxis]
    if result.trajectory is not None:
        times = np.linspace(0.0, result.rest_time, TIMES)
        if result.events is not None:  # paths have corners at events
            times = np.union1d(times, result.events["t"])
        path = np.concatenate([result.sample(times).positions, path])
    counts = ", ".join(f"{kind} {count}" for kind, count in result.collision_counts.items())
    status = result.status.name.lower()
    text = f"{result.engine}, {status} at t = {result.rest_time:.6g} s; {counts}"
    return _template("result.html").render(drawn=Markup(picture(result.scene, path)), text=text)


def _template(name: str) -> Template:
    return templates_of("ghostball.reports").get_template(name)


VIEWS.update({Scene: picture, Result: ended})
