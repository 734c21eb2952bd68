"""Draw the residuals of a fit of physics, one for each event."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ghostball.reports import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ghostball.validation.measured.fit.fit_result import Fit

_TITLES = {
    "rolling": "Rolling balls: deceleration",
    "cushion": "Cushion rebounds: velocity after",
    "hit": "Hits on a resting ball: positions and velocities after",
}
_BINS = 8
_SHOWN = 6.0
"""Residuals beyond this many standard errors are drawn at the edge."""


def draw_fit(fitted: Fit, path: Path) -> None:
    """Write a picture with a panel for each family of events."""
    with style.drawing():
        families = {name: one.residuals for name, one in fitted.solutions.items()}
        figure = style.new_figure(9.0, 1.2 + 2.5 * len(families))
        rows = figure.subplots(len(families), 1, squeeze=False)[:, 0]
        for axes, (name, left) in zip(rows, families.items(), strict=True):
            speeds = np.array([one.speed for one in fitted.families[name]])
            _draw(axes, speeds, left)
            axes.set_title(f"{_TITLES[name]} ({len(left)})", loc="left")
        rows[-1].set_xlabel("speed before [m/s]")
        style.set_title(figure, "Residuals of the fit, in measurement errors")
        style.save_one(figure, path, "Residual of each event in a fit of physics to tracks")


def _draw(axes: Axes, speeds: NDArray[np.float64], left: NDArray[np.float64]) -> None:
    """Draw residuals (n, k) as points, means of groups with error bars, and the noise level."""
    x, y = np.repeat(speeds, left.shape[1]), left.ravel()
    axes.axhspan(-2.0, 2.0, color=style.GREY, alpha=0.12, linewidth=0.0)
    axes.axhline(0.0, color=style.GREY, linewidth=0.8)
    axes.plot(x, np.clip(y, -_SHOWN, _SHOWN), ".", markersize=3.0, alpha=0.5)
    for part in np.array_split(np.argsort(x), _BINS):
        if len(part) > 1:
            error = np.std(y[part]) / np.sqrt(len(part))
            axes.errorbar(np.mean(x[part]), np.mean(y[part]), error, fmt="o", color="black")
    axes.set_ylim(-_SHOWN - 0.3, _SHOWN + 0.3)
    axes.set_ylabel("residual")
