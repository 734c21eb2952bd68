"""Draw shots that need the future work of the paper's section 6, on every engine.

6.1: orientations of balls, by the paper's own rule and by quaternions. 6.2: sliding balls. 6.3: air
drag and restitution. 6.4: balls in flight. Below each picture is the verdict on every engine.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from textwrap import shorten
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.pictures.shots import our_shot, recorded
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.paper.rotation import turned_by_frames
from ghostball.reports import style
from ghostball.reports.accuracy import accuracy_text
from ghostball.reports.figures.heights import draw_side, part_in_flight
from ghostball.reports.shots import Run, Shot, motion_of_run
from ghostball.validation.results.store import Motion, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure


TURNING = ("wall-bounce", "masse")
SLIPPING = "sliding-swerve"
AIR, RESTITUTION = "air-rolls", "restitution-bounce"
FLIGHT = "flight-jump"

ABOUT = {AIR: "no air drag", RESTITUTION: "restitution", FLIGHT: "airborne balls"}
"""Feature that a scene tests. If an engine doesn't support the scene, this reason is shown."""

FRAME = 0.02
"""The paper's time step [s]."""

RULES: dict[str, dict[str, Any]] = {
    "the paper's rule, r = v × k": {"color": style.BLACK, "linestyle": (0.0, (1.0, 1.0))},
    "the same about k × v": {"color": style.BROWN, "linestyle": (0.0, (4.0, 2.0))},
}
"""The paper's rule as printed, which turns balls backwards, and the rule about the other axis."""

SMALLEST_TURN = 1e-9
"""Smallest angle on the axis [rad]."""

WIDTH, HEIGHT, ROW_HEIGHT = 10.0, 3.4, 0.19
"""Width of a figure, height of its panels, and height of an engine's row below them [inch]."""


def draw_turning(results: Results) -> Figure:
    """Draw the error of the first ball's orientation, by the paper's rule and on each engine.

    The reference is the motion of Ghostball's engine; its orientation is exact to rounding.
    """
    stored = [our_shot(results, name) for name in TURNING]
    shots = [shot for shot, _ in stored]
    turns = [turned_off(shot, ours) for shot, ours in stored]
    ends = [{label: float(off[-1]) for label, (_, off) in turn.items()} for turn in turns]
    figure, panels = _new_figure("6.1: orientations of balls", shots, ends)
    for axes, shot, turn in zip(panels, shots, turns, strict=True):
        looks = {run.label: _look(run) for run in shot.drawn} | RULES
        for label, (times, off) in turn.items():
            look = {"label": label, **looks[label]}
            axes.plot(times, np.maximum(off, SMALLEST_TURN), **look)
        axes.set(yscale="log", xlabel="time [s]", ylim=(SMALLEST_TURN, 6.0))
        axes.set_title(f"{shot.scene.name}: orientation of the first ball", fontsize=9)
        axes.grid(visible=True)
    panels[0].set_ylabel("orientation error [rad]")
    # The errors in the massé are small, so its panel has room for the legend of both panels.
    panels[1].legend(*panels[0].get_legend_handles_labels(), fontsize=6.5, loc=(0.55, 0.05))
    return figure


def turned_off(shot: Shot, ours_run: Run) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Return times [s] and orientation errors [rad] of the first ball, by engine and by rule.

    The reference is the motion of Ghostball's engine, with spins that are linear between its stored
    times.
    """
    ours = motion_of_run(ours_run)
    times = np.linspace(0.0, ours.times[-1], 301)[1:]
    right = _orientation(ours, times)
    found = {
        run.label: (times, _angle(_orientation(motion_of_run(run), times), right))
        for run in shot.drawn
        if not run.style.ours
    }
    frames = np.arange(FRAME, ours.times[-1], FRAME)  # the ends of the time steps
    velocities = recorded(ours).sample(frames).velocities[:, :1]
    at_frames = _orientation(ours, frames)
    for label, sign in zip(RULES, (1.0, -1.0), strict=True):
        by_rule = turned_by_frames(sign * velocities, shot.scene.radii[:1], FRAME)[:, 0]
        found[label] = frames, _angle(by_rule, at_frames)
    return found


def draw_slipping(results: Results) -> Figure:
    """Draw the parabolic path of a sliding ball, and its slip speed."""
    shot, _ = our_shot(results, SLIPPING)
    figure, (path, slip) = _new_figure("6.2: a sliding ball", [shot])
    radius = float(shot.scene.radii[0])
    for run in shot.drawn:
        motion = motion_of_run(run)
        x, y = motion.positions[:, 0, :2].T
        path.plot(x, y, **_look(run))
        (vx, vy), (wx, wy) = motion.velocities[:, 0, :2].T, motion.angular_velocities[:, 0, :2].T
        size = np.hypot(vx - radius * wy, vy + radius * wx)
        slip.plot(motion.times, size, **_look(run))
    start, velocity = shot.scene.positions[0], shot.scene.velocities[0]
    way = float(velocity @ velocity) / (2.0 * shot.scene.physics.rolling_friction * 9.81)
    end = start + way * velocity / np.linalg.norm(velocity)
    path.plot(*zip(start[:2], end[:2], strict=True), color=style.GREY, ls=":", label="the paper")
    path.set(xlabel="x [m]", ylabel="y [m]")
    path.set_title("path; dotted: a ball that always rolls, as in the paper", fontsize=9)
    slip.set(xlabel="time [s]", xlim=(0.0, 1.0))
    slip.set_title("slip speed of the lowest point [m/s]", fontsize=9)
    path.legend(fontsize=7.5)
    return figure


def draw_air(results: Results) -> Figure:
    """Draw the distances of balls that roll with air drag, and an inelastic rebound."""
    rolls, bounce = (our_shot(results, name)[0] for name in (AIR, RESTITUTION))
    figure, (ways, speeds) = _new_figure("6.3: air drag and restitution", [rolls, bounce])
    physics = rolls.scene.physics
    a, b = physics.rolling_friction * physics.gravity, 5.0 / 7.0 * physics.air_drag
    v = np.linspace(0.7, 11.0, 300)
    without = "without air drag, v² / (2 μ g)"
    ways.plot(v, v**2 / (2.0 * a), color=style.GREY, ls="--", label=without)
    closed = np.log1p(b * v**2 / a) / (2.0 * b)
    ways.plot(v, closed, color=style.BLACK, label="closed form with air drag")
    for run in rolls.drawn:
        motion = motion_of_run(run)
        gone = np.linalg.norm(motion.positions[-1] - motion.positions[0], axis=1)
        at = np.linalg.norm(motion.velocities[0], axis=1)
        ways.plot(at, gone, **_look(run) | {"linestyle": "none", "marker": run.style.marker})
    ways.set(xlabel="initial speed [m/s]", ylabel="distance [m]", yscale="log", xscale="log")
    ways.set_title("distance of a rolling ball with k = 0.0041 / m", fontsize=9)
    ways.legend(fontsize=7.5)
    for run in bounce.drawn:
        motion = motion_of_run(run)
        speeds.plot(motion.times, np.linalg.norm(motion.velocities[:, 0], axis=1), **_look(run))
    speeds.set(xlabel="time [s]", ylabel="speed [m/s]")
    speeds.set_title("an inelastic cushion: restitution-bounce", fontsize=9)
    return figure


def draw_flight(results: Results) -> Figure:
    """Draw a jump shot from the side, on every engine that supports it."""
    shot, ours_run = our_shot(results, FLIGHT)
    figure, (side, off) = _new_figure("6.4: a ball in flight", [shot])
    draw_side(side, shot, _look)
    side.legend(fontsize=7.5, loc="upper right")
    ours = motion_of_run(ours_run)
    end = part_in_flight(shot)
    for run in shot.drawn:
        if run.style.ours:
            continue
        motion = motion_of_run(run)
        place = recorded(ours).sample(motion.times).positions
        distance = np.linalg.norm(motion.positions - place, axis=2).max(axis=1)
        off.plot(motion.times, np.maximum(distance, 1e-7), **_look(run))
    off.set(yscale="log", xlabel="time [s]", ylabel="distance from ghostball [m]")
    off.axvspan(0.0, end, color=style.FAINT, alpha=0.5)
    off.set_title("largest distance of a ball; grey: while a ball is in flight", fontsize=9)
    return figure


SECTION_FIGURES: Mapping[str, Callable[[Results], Figure]] = {
    "paper-section-6-1": draw_turning,
    "paper-section-6-2": draw_slipping,
    "paper-section-6-3": draw_air,
    "paper-section-6-4": draw_flight,
}


def _new_figure(
    title: str, shots: Any, turned: Sequence[Mapping[str, float]] = ()
) -> tuple[Figure, Any]:
    """Return a figure with two panels, and a row for each engine below them.

    `turned`: for each shot, the final orientation error of each engine and rule [rad].
    """
    rows = _rows(shots, turned)
    beneath = ROW_HEIGHT * (len(rows) + 1)
    figure = style.new_figure(WIDTH, HEIGHT + beneath)
    parts: Any = figure.subfigures(2, 1, height_ratios=[HEIGHT, beneath])
    upper, lower = parts
    style.set_title(upper, f"The paper's section {title}")
    axes = lower.subplots()
    axes.set_axis_off()
    places = [0.0, 0.24, *(0.24 + 0.38 * k for k in range(1, len(shots)))]
    heads = ["engine", *(shot.scene.name for shot in shots)]
    for k, row in enumerate([heads, *rows]):
        for x, text in zip(places, row, strict=True):
            axes.text(
                x,
                1.0 - (k + 0.5) / (len(rows) + 1),
                text,
                transform=axes.transAxes,
                fontsize=7.5,
                va="center",
                fontweight="bold" if k == 0 else "normal",
            )
    return figure, upper.subplots(1, 2)


def _rows(shots: list[Shot], turned: Sequence[Mapping[str, float]]) -> list[list[str]]:
    """Return a row for each engine: its name, and the verdict on each shot."""
    labels = list(dict.fromkeys(run.label for shot in shots for run in shot.runs))
    wide = 120 if len(shots) == 1 else 62
    rows = []
    for label in [*labels, *RULES] if turned else labels:
        row = [label if label in RULES else style.engine_style(label).name]
        for k, shot in enumerate(shots):
            run = next((run for run in shot.runs if run.label == label), None)
            text = "" if label in RULES else _verdict(run, ABOUT.get(shot.scene.name, ""))
            if turned and label in turned[k]:
                text += f"{', ' if text else ''}orientation error {turned[k][label]:.2g} rad"
            row.append(shorten(text, wide, placeholder=" ..."))
        rows.append(row)
    return rows


def _verdict(run: Run | None, about: str) -> str:
    if run is None or run.case is None:
        return "not run"
    if run.case.outcome == "ran":
        return accuracy_text(run.case)
    reasons = run.case.reason.split("; no ")
    said = next((reason for reason in reasons if about in f"no {reason}"), reasons[0])
    lacks = run.case.outcome == "not-representable"
    outcome = "unsupported" if lacks else run.case.outcome
    return f"{outcome}: no {said.removeprefix('no ')}"


def _look(run: Run) -> dict[str, Any]:
    look = run.style
    width = 2.6 if look.ours else 1.2
    alpha = 0.45 if look.ours else 1.0
    return {
        "color": look.colour,
        "linestyle": look.line,
        "linewidth": width,
        "alpha": alpha,
        "label": look.name,
    }


def _orientation(motion: Motion, times: FloatArray) -> FloatArray:
    """Return the orientation of the first ball, (k, 4); spins are linear between stored times."""
    return recorded(motion, slice(1)).orientation(times)[:, 0]


def _angle(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the angle between two orientations, (k,) [rad]."""
    # From the difference of the quaternions: the cosine is inaccurate for small angles.
    near = np.minimum(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
    angle: FloatArray = 4.0 * np.arcsin(np.minimum(0.5 * near, 1.0))
    return angle
