"""Draw how the distance of neighbouring shots grows, and its prediction by the tangent map.

Section 4.2 of the paper describes this sensitivity.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ghostball.engine.sensitivity import PARTS
from ghostball.model import GhostballError, Scene
from ghostball.model.arrays import FloatArray
from ghostball.reports import style
from ghostball.validation.grading.tolerances import TOLERANCE
from ghostball.validation.results.store import Results
from ghostball.validation.runs.engine_runs import run_ours
from ghostball.validation.runs.rolling import rolling_spin
from ghostball.validation.runs.sampling import events_of, union_times

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


SPEED_CHANGES = (1e-4, 1e-7, 1e-10, 1e-13)
"""Added speeds of the fastest ball in the neighbouring shots [m/s]. The first is the paper's
(section 4.2): changes as small as .0001 vastly change the final resting state."""

COLOURS = (style.VERMILLION, style.BLUE, style.GREEN, style.PURPLE)
"""Colours of the neighbouring shots."""

WIDTH, HEIGHT = 9.6, 4.6

_UNIFORM, _LIMIT = 200, 600  # sampled times on a uniform grid; largest number of all times

_LOWEST = 1e-16
"""Smallest distance in the picture [m]."""


@dataclass(frozen=True, eq=False)
class Neighbours:
    """A shot with its neighbours.

    `times` (k,) float64 [s].
    `growth` (k,) float64 [m]: the largest `Result.sensitivity` of a ball; NaN where no derivative
        exists.
    `distance` (neighbours, k) float64 [m]: the largest distance between the positions of a ball in
        the neighbour and in the shot.
    `predicted` (neighbours, k) float64 [m]: the same distance, predicted by the tangent map of the
        shot; NaN where no derivative exists.
    """

    times: FloatArray
    growth: FloatArray
    distance: FloatArray
    predicted: FloatArray


def neighbours_of(scene: Scene) -> Neighbours:
    """Compare a shot with shots in which the fastest ball is faster by `SPEED_CHANGES`."""
    result = run_ours(scene)
    times = union_times(result.rest_time, events_of(result)["t"], uniform=_UNIFORM, limit=_LIMIT)
    fastest = int(np.argmax(np.linalg.norm(scene.velocities, axis=1)))
    along = scene.velocities[fastest, :2] / np.linalg.norm(scene.velocities[fastest, :2])
    direction = np.zeros((1, len(scene.balls), PARTS))
    direction[0, fastest, 2:4] = along
    tangent = result.tangent(direction).sample(times)[:, 0, :, :2]
    parting = _finite(np.max(np.linalg.norm(tangent, axis=2), axis=1))
    places = result.sample(times).positions
    neighbours = [
        run_ours(_faster(scene, fastest, change * along)).sample(times).positions
        for change in SPEED_CHANGES
    ]
    return Neighbours(
        times,
        _finite(np.max(result.sensitivity(times), axis=1)),
        np.array([np.linalg.norm(there - places, axis=2).max(axis=1) for there in neighbours]),
        np.outer(SPEED_CHANGES, parting),
    )


def _faster(scene: Scene, ball: int, by: FloatArray) -> Scene:
    """Return the scene with a velocity added to a ball; a rolling ball still rolls."""
    balls = [one.model_dump(exclude_unset=True) for one in scene.balls]
    velocity = scene.velocities[ball].copy()
    velocity[:2] += by
    balls[ball]["velocity"] = tuple(velocity[:2].tolist())
    if scene.rolls[ball]:
        spin = float(scene.angular_velocities[ball, 2])
        balls[ball]["angular_velocity"] = (
            rolling_spin(velocity.tolist(), float(scene.radii[ball]), spin) if spin else None
        )
    return Scene.model_validate({**scene.model_dump(by_alias=True), "balls": balls})


def _finite(values: FloatArray) -> FloatArray:
    """Return the values with NaN for infinite values."""
    finite: FloatArray = np.where(np.isfinite(values), values, np.nan)
    return finite


def draw_chaos(results: Results) -> Figure:
    """Draw the distance of neighbouring shots against time, for each scene with the tag "chaos".

    Raises `GhostballError` if the results have no such scene.
    """
    cases = {case.scene: case for case in results.cases if "chaos" in case.tags}
    if not cases:
        raise GhostballError(
            f'{results.path}: the picture "chaos" needs scenes with the tag "chaos", but the '
            "results have none. Run the full suite"
        )
    figure = style.new_figure(WIDTH, HEIGHT)
    panels = figure.subplots(1, len(cases), sharey=True, squeeze=False)[0]
    for axes, case in zip(panels, cases.values(), strict=True):
        _draw_panel(axes, neighbours_of(case.load_scene()), case.shot_horizon)
        axes.set_title(case.scene, fontsize=9)
    panels[0].set_ylabel("largest distance of a ball in the two shots [m]")
    legend = panels[0].get_legend_handles_labels()
    figure.legend(*legend, loc="outside lower center", ncols=3, fontsize=8)
    style.set_title(
        figure, "Shots with almost equal starts: distances, and their tangent map (dotted)"
    )
    return figure


def _draw_panel(axes: Axes, shot: Neighbours, horizon: float | None) -> None:
    for size, distance, predicted, colour in zip(
        SPEED_CHANGES, shot.distance, shot.predicted, COLOURS, strict=True
    ):
        label = f"{size:g} m/s faster"
        axes.plot(shot.times, _shown(distance), color=colour, linewidth=1.5, label=label)
        axes.plot(shot.times, _shown(predicted), color=colour, linewidth=1.1, linestyle=":")
    noise = 32.0 * 2.0**-53 * shot.growth
    axes.fill_between(
        shot.times,
        _LOWEST,
        np.maximum(noise, _LOWEST),
        color=style.FAINT,
        alpha=0.6,
        linewidth=0.0,
        label="32 roundings of Ghostball's engine",
    )
    axes.axhline(TOLERANCE, color=style.GREY, linewidth=0.8, linestyle=(0.0, (4.0, 2.0)))
    if horizon is not None:
        label = f"predictability horizon, for {style.format_length(TOLERANCE)}"
        axes.axvline(horizon, color=style.BLACK, linewidth=1.0, label=label)
        axes.annotate(
            f"{horizon:.2f} s",
            (horizon, _LOWEST),
            xytext=(3.0, 4.0),
            textcoords="offset points",
            fontsize=8,
        )
    axes.set(yscale="log", xlabel="time [s]", xlim=(0.0, shot.times[-1]))
    axes.set_ylim(_LOWEST, max(30.0, 2.0 * float(shot.distance[:, -1].max())))
    axes.grid(visible=True)


def _shown(distances: Any) -> Any:
    """Return distances with NaN for 0, which a logarithmic axis can't show."""
    return np.where(distances > 0.0, distances, np.nan)
