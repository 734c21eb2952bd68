"""Draw two effects of cut shots from stored sweeps, with their closed forms.

The 30 degree rule: the direction of a rolling cue ball after a cut. Throw: the angle between the
path of the object ball and the line of centres, caused by friction between the balls, against cut
angle and side spin. A sweep is a scene with many shots side by side: balls 0 and 1, balls 2 and 3,
and so on.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.pictures.shots import our_shot, write_at
from ghostball.model import EventKind, Scene
from ghostball.model.arrays import FloatArray
from ghostball.reports import style
from ghostball.reports.shots import Run, Shot
from ghostball.validation.results.store import Motion, Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


DEFLECTION = "thirty-degree-rule"
THROW_BY_ANGLE = "throw-by-angle"
THROW_BY_SPIN = "throw-by-spin"

THREE_QUARTER_BALL, HALF_BALL, QUARTER_BALL = (
    math.degrees(math.asin(1.0 - fraction)) for fraction in (0.75, 0.5, 0.25)
)
"""Cut angles of shots in which the cue ball covers 3/4, 1/2 and 1/4 of the object ball [deg]."""

PUBLISHED_DEFLECTIONS = (
    (10.0, 21.681),
    (THREE_QUARTER_BALL, 27.626),
    (20.0, 31.868),
    (28.126, 33.749),
    (HALF_BALL, 33.670),
    (40.0, 31.196),
    (45.0, 29.055),
    (QUARTER_BALL, 27.267),
    (60.0, 20.633),
    (80.0, 7.116),
)
"""Cut angle and deflection of the cue ball [deg]: Alciatore, proof 3.3 and its table."""

NAMED_DEFLECTIONS = (
    (THREE_QUARTER_BALL, "3/4 ball", (-10, 3), "right"),
    (HALF_BALL, "half ball", (8, -15), "left"),
    (QUARTER_BALL, "1/4 ball", (10, 3), "left"),
)
"""Cut angle [deg], name, offset of the name [points], and end of the name at the point."""

MPH = 0.44704  # [m/s]
WIDTH = 8.8
SMALLEST = 1e-15
"""Smallest difference in the picture [deg]; the rounding of a number near 30 is 4e-15."""


@dataclass(frozen=True)
class Cut:
    """One shot of a sweep on one engine.

    `cut` [deg]: angle between the cue ball's path and the line of centres, from the scene.
    `speed` [m/s]: speed of the cue ball at the collision, from a formula for a cue ball without
        horizontal spin at the collision.
    `spin`: r wz at the collision, divided by `speed`, positive for outside english; from a formula.
    `cue`, `target` [deg]: final directions of cue ball and object ball, as angles from the cue
        ball's path; `target` is positive to the object ball's side, `cue` to the other side.
    """

    cut: float
    speed: float
    spin: float
    cue: float
    target: float

    @property
    def throw(self) -> float:
        """Angle from the line of centres, positive towards the cue ball's path [deg]."""
        return self.cut - self.target


def natural_deflection(cut: FloatArray) -> FloatArray:
    """Return the deflection of a rolling cue ball, after it rolls again [rad].

    `cut` (k,) float64 [rad].

    The deflection is atan(s c / (s^2 + 2/5)), with sine s and cosine c of the cut angle, for an
    elastic collision without friction between the balls (Wallace and Schroeder 1988, Am. J. Phys.
    56 815; Alciatore, proof 3.3).
    """
    sin, cos = np.sin(cut), np.cos(cut)
    angle: FloatArray = np.arctan2(sin * cos, sin**2 + 0.4)
    return angle


def throw_angle(scene: Scene, cut: FloatArray, speed: FloatArray, spin: FloatArray) -> FloatArray:
    """Return the throw of an elastic collision with a cue ball without horizontal spin [rad].

    `scene`: the scene with the friction between the balls.
    `cut` (k,) float64 [rad].
    `speed` (k,) float64 [m/s].
    `spin` (k,) float64: r wz divided by the speed.

    The tangent of the throw is min(mu, |U| / (7 v c)), with the slip U = v s - R wz of the surfaces
    (Alciatore, proof A.14). The friction "alciatore" is mu = 9.951e-3 + 0.108 exp(-1.088 |U|), with
    U in m/s.
    """
    slip = speed * (np.sin(cut) - spin)
    friction: Any = scene.physics.ball_friction
    if friction == "alciatore":
        friction = 9.951e-3 + 0.108 * np.exp(-1.088 * np.abs(slip))
    sticking = np.abs(slip) / (7.0 * speed * np.cos(cut))
    angle: FloatArray = np.sign(slip) * np.arctan(np.minimum(friction, sticking))
    return angle


def cuts_of(scene: Scene, motion: Motion) -> list[Cut]:
    """Return the shots of a sweep in which the two balls collide, in the order of the scene."""
    found = []
    for cue in range(0, len(scene.balls) - 1, 2):
        if _met(motion, cue):
            found.append(_cut_of(scene, motion, cue))
    return found


def draw_deflection(results: Results) -> Figure:
    """Draw the 30 degree rule."""
    shot, _ = our_shot(results, DEFLECTION)
    figure = style.new_figure(WIDTH, 6.4)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2.6, 1.0])
    angles = np.linspace(0.0, 90.0, 361)
    curve = np.degrees(natural_deflection(np.radians(angles)))
    above.plot(
        angles, curve, color=style.GREY, linewidth=1.6, label="closed form (Alciatore, proof 3.3)"
    )
    above.plot(*zip(*PUBLISHED_DEFLECTIONS, strict=True), **_PUBLISHED)
    for at, name, offset, end in NAMED_DEFLECTIONS:
        value = float(np.degrees(natural_deflection(np.radians(np.array([at]))))[0])
        write_at(above, (at, value), name, offset, end)
    top = 38.0
    for run, cuts in _runs(shot):
        x = np.array([cut.cut for cut in cuts])
        y = np.array([cut.cue for cut in cuts])
        top = max(top, float(y.max()) + 2.0)
        _draw_points(above, run, x, y, label=True)
        _draw_points(below, run, x, _size(y - np.degrees(natural_deflection(np.radians(x)))))
    above.set(ylabel="deflection of the cue ball [deg]", xlim=(0.0, 90.0), ylim=(0.0, top))
    above.grid(visible=True)
    _finish_differences(below)
    below.set_xlabel("cut angle [deg]")
    figure.legend(*above.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    style.set_title(figure, "30 degree rule: the direction of a rolling cue ball after a cut")
    return figure


def draw_throw(results: Results) -> Figure:
    """Draw throw against cut angle and side spin."""
    by_angle, by_spin = (our_shot(results, name)[0] for name in (THROW_BY_ANGLE, THROW_BY_SPIN))
    figure = style.new_figure(WIDTH, 6.0)
    grid = figure.subplots(2, 2, sharex="col", height_ratios=[2.6, 1.0])
    for column, shot in enumerate((by_angle, by_spin)):
        above, below = grid[0, column], grid[1, column]
        varies = "cut" if column == 0 else "spin"
        _draw_throw_curves(above, shot, varies)
        for run, cuts in _runs(shot):
            cut, speed, spin, throw = np.array([[c.cut, c.speed, c.spin, c.throw] for c in cuts]).T
            x = cut if varies == "cut" else spin
            _draw_points(above, run, x, throw, label=column == 0)
            exact = np.degrees(throw_angle(shot.scene, np.radians(cut), speed, spin))
            _draw_points(below, run, x, _size(throw - exact))
        above.grid(visible=True)
        _finish_differences(below)
    grid[0, 0].set(ylabel="throw [deg]", xlim=(0.0, 90.0))
    grid[0, 0].set_title("a stun shot, against the cut angle", fontsize=9)
    grid[1, 0].set_xlabel("cut angle [deg]")
    grid[0, 1].set_title("a half-ball stun shot, against side spin", fontsize=9)
    grid[0, 1].set_xlim(-1.42, 1.1)
    grid[1, 1].set_xlabel("side spin R ω / v [1], outside english positive")
    grid[1, 1].set_ylabel("")
    _mark_gearing(grid[0, 1], by_spin)
    legend = grid[0, 0].get_legend_handles_labels()
    figure.legend(*legend, loc="outside lower center", ncols=6)
    friction: Any = by_angle.scene.physics.ball_friction
    law = ", falling with speed," if friction == "alciatore" else f" of {friction:g}"
    style.set_title(figure, f"Throw: friction between the balls{law} deflects the object ball")
    return figure


PHYSICS_FIGURES: dict[str, Callable[[Results], Figure]] = {
    "physics-deflection": draw_deflection,
    "physics-throw": draw_throw,
}

_PUBLISHED: dict[str, Any] = {
    "linestyle": "none",
    "marker": "D",
    "markersize": 8.0,
    "markerfacecolor": "none",
    "markeredgecolor": style.ORANGE,
    "markeredgewidth": 1.4,
    "label": "published numbers (Alciatore)",
}


def _runs(shot: Shot) -> Iterator[tuple[Run, list[Cut]]]:
    """Yield each engine with a motion, and its shots; Ghostball's last, so that it is on top."""
    for run in sorted(shot.drawn, key=lambda run: run.style.ours):
        cuts = cuts_of(shot.scene, run.motion) if run.motion is not None else []
        if cuts:
            yield run, cuts


def _met(motion: Motion, cue: int) -> bool:
    """Return whether ball `cue` and the next ball collided."""
    of_balls = motion.events[motion.events["kind"] == EventKind.BALL_BALL]
    pairs = np.sort(np.stack([of_balls["a"], of_balls["b"]], axis=1), axis=1)
    return bool(np.any(np.all(pairs == [cue, cue + 1], axis=1)))


def _cut_of(scene: Scene, motion: Motion, cue: int) -> Cut:
    start, target = scene.positions[cue : cue + 2, :2]
    velocity, angular_velocity = scene.velocities[cue, :2], scene.angular_velocities[cue]
    path = velocity / np.hypot(*velocity)
    offset = _cross(path, target - start)
    side = 1.0 if offset >= 0.0 else -1.0
    radius, reach = scene.radii[cue], scene.radii[cue] + scene.radii[cue + 1]
    # Cloth friction conserves v + (2/5) R (w x z); without horizontal spin this is v.
    start_speed = float(np.hypot(*velocity))
    speed = start_speed + 0.4 * radius * _cross(path, angular_velocity[:2])
    slide = (start_speed - speed) / (scene.sliding_frictions[cue] * scene.physics.gravity)
    left = max(abs(angular_velocity[2]) - scene.spinning_friction_rates[cue] * slide, 0.0)
    return Cut(
        cut=float(np.degrees(np.arcsin(abs(offset) / reach))),
        speed=speed,
        spin=float(side * radius * np.copysign(left, angular_velocity[2]) / speed),
        cue=-side * _direction(motion, cue, path),
        target=side * _direction(motion, cue + 1, path),
    )


def _direction(motion: Motion, ball: int, path: FloatArray) -> float:
    """Return the angle from `path` to a ball's final velocity, counter-clockwise [deg].

    The final velocity is taken at the last stored time with at least a tenth of the largest speed,
    because a ball at rest has no direction.
    """
    velocities = motion.velocities[:, ball, :2]
    speeds = np.hypot(velocities[:, 0], velocities[:, 1])
    last = velocities[np.flatnonzero(speeds >= 0.1 * speeds.max())[-1]]
    return float(np.degrees(np.arctan2(_cross(path, last), path @ last)))


def _cross(a: FloatArray, b: FloatArray) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def _draw_throw_curves(axes: Axes, shot: Shot, varies: str) -> None:
    """Draw the closed form for each speed of the sweep, and write the speed beside its curve."""
    cuts = next(iter(_runs(shot)))[1]
    speeds = sorted({round(cut.speed, 3) for cut in cuts})
    lines = ("-", (0.0, (6.0, 2.0)), (0.0, (2.0, 1.5)), "-.")
    for k, (speed, line) in enumerate(zip(speeds, lines, strict=False)):
        along_cut = varies == "cut"
        x = np.linspace(0.5, 88.0, 351) if along_cut else np.linspace(-1.05, 1.05, 421)
        cut = x if along_cut else np.full(len(x), cuts[0].cut)
        spin = np.zeros(len(x)) if along_cut else x
        exact = throw_angle(shot.scene, np.radians(cut), np.full(len(x), speed), spin)
        y = np.degrees(exact)
        label = "closed form (Alciatore, proof A.14)" if along_cut and k == 0 else None
        axes.plot(x, y, color=style.GREY, linestyle=line, label=label)
        name = f"{speed / MPH:.0f} mph"
        if along_cut:
            write_at(axes, (x[-1], y[-1]), name, (0, 9), "right")
        else:
            write_at(axes, (x[0], y[0]), name, (-4, -3), "right")


def _mark_gearing(axes: Axes, shot: Shot) -> None:
    cuts = next(iter(_runs(shot)))[1]
    gearing = float(np.sin(np.radians(cuts[0].cut)))
    axes.axhline(0.0, color=style.FAINT, linewidth=0.8)
    axes.axvline(gearing, color=style.VERMILLION, linewidth=1.0, linestyle=(0.0, (4.0, 2.0)))
    write_at(axes, (gearing, 0.0), "gearing:\nno throw", (-8, -30), "right", style.VERMILLION)


def _draw_points(
    axes: Axes, run: Run, x: FloatArray, y: FloatArray, *, label: bool = False
) -> None:
    axes.plot(
        x,
        y,
        linestyle="none",
        marker=run.style.marker,
        markersize=4.5 if run.style.ours else 4.0,
        color=run.style.colour,
        markerfacecolor=run.style.colour if run.style.ours else "none",
        label=run.style.name if label else None,
    )


def _size(differences: FloatArray) -> FloatArray:
    return np.maximum(np.abs(differences), SMALLEST)


def _finish_differences(axes: Axes) -> None:
    """Scale and label a logarithmic axis of differences [deg]."""
    axes.set_yscale("log")
    axes.set_ylim(SMALLEST / 3.0, 30.0)
    exponents = (-15, -10, -5, 0)
    axes.set_yticks([10.0**e for e in exponents], [style.power_of_ten(e) for e in exponents])
    axes.minorticks_off()
    axes.set_ylabel("from the closed\nform [deg]")
    axes.grid(visible=True)
