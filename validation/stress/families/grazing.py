"""Grazing: two balls that only just touch or miss, and a ball that only just reaches a cushion.

The hard part of every detector of collisions. How deep the path of a shot really goes is computed
from the scene's own doubles, in exact or 50-digit arithmetic, so rounding of the scene itself can't
turn a hit into a miss. Past a depth of 1e-13 diameters doubles can't tell one from the other.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from mpmath import mp, mpf, workdps

from ghostball.model import Ball, EventKind, Physics, Result, Scene, Table
from ghostball.validation.stress.trial import Family, SceneTrial, Suite, Trial, Verdict

SPEED = 1.0
WAY = 0.1
"""Speed of the moving ball [m/s], and its way to the other one, or to the cushion [m]."""

SHALLOWEST = 13
"""Impact depths go from 1e-1 to 10 to the minus this, in diameters."""

_RADIUS = Ball(id="any", position=(0.0, 0.0)).radius
_DIGITS = 50


def straight(name: str, physics: Physics, depth: float, turn: float, ratio: float = 1.0) -> Scene:
    """Return a shot that passes a resting ball, straight, `depth` diameters nearer than a touch.

    Turned by an angle [rad] about the object ball, so that every coordinate is rounded. Its
    radius is `ratio` times the cue ball's.
    """
    c, s = math.cos(turn), math.sin(turn)
    aside = (1.0 + ratio) * _RADIUS * (1.0 - depth)
    return Scene(
        name=name,
        physics=physics,
        t_max=2.0 * WAY / SPEED,
        balls=[
            Ball(
                id="cue",
                position=(-c * WAY - s * aside, -s * WAY + c * aside),
                velocity=(SPEED * c, SPEED * s),
            ),
            Ball(id="object", position=(0.0, 0.0), radius=ratio * _RADIUS),
        ],
    )


def curved(name: str, depth: float, turn: float) -> Scene:
    """Return a shot whose path sidespin bends round a resting ball, as `straight`."""
    physics = Physics(preset="pool", sliding_friction=0.4)
    c, s = math.cos(turn), math.sin(turn)
    # It rolls, and spins about the line of the shot too: the cloth pushes it sideways, along a
    # parabola, until after it has passed.
    spin = SPEED / _RADIUS
    aside = 3.0 * spin
    cue = Ball(
        id="cue",
        position=(0.0, 0.0),
        velocity=(SPEED * c, SPEED * s),
        angular_velocity=(-aside * c - spin * s, -aside * s + spin * c, 0.0),
    )
    with workdps(_DIGITS):
        path = _path(cue, physics)
        t = mpf(WAY) / mpf(SPEED)
        (x, y), (vx, vy) = path(t), tuple(mp.diff(lambda u, k=k: path(u)[k], t) for k in (0, 1))
        speed = mp.hypot(vx, vy)
        reach = 2 * mpf(_RADIUS) * (1 - mpf(depth))
        place = (float(x + reach * vy / speed), float(y - reach * vx / speed))
    return Scene(
        name=name,
        physics=physics,
        t_max=2.0 * WAY / SPEED,
        balls=[cue, Ball(id="object", position=place)],
    )


def at_cushion(name: str, depth: float, _turn: float) -> Scene:
    """Return a shot that sidespin bends back just where it reaches a cushion."""
    physics = Physics(preset="pool", sliding_friction=0.4)
    spin = 2.0 * SPEED / _RADIUS
    # The slip is all sideways, so that the cloth's push is away from the cushion.
    cue = Ball(
        id="cue",
        position=(0.3, 0.0),
        velocity=(SPEED, 0.4 * SPEED),
        angular_velocity=(spin, SPEED / _RADIUS, 0.0),
    )
    with workdps(_DIGITS):
        path = _path(cue, physics)
        apex = _peak(lambda t: path(t)[1], 0.4 * SPEED / (0.4 * 9.81))
        y = float(mpf(0.6) - mpf(_RADIUS) - apex + 2 * mpf(_RADIUS) * mpf(depth))
    return Scene(
        name=name,
        physics=physics,
        table=Table(length=1.2, width=0.6),
        t_max=2.0 * WAY / SPEED,
        balls=[cue.model_copy(update={"position": (0.3, y, cue.radius)})],
    )


def straight_depth(scene: Scene) -> float:
    """Return how deep a straight path goes into the resting ball, in diameters; a miss: below 0.

    In exact arithmetic but for the last division.
    """
    cue, other = scene.balls
    x, y = (Fraction(other.position[k]) - Fraction(cue.position[k]) for k in (0, 1))
    vx, vy = map(Fraction, cue.velocity[:2])
    diameter = Fraction(cue.radius) + Fraction(other.radius)
    square = (x * vy - y * vx) ** 2 / (vx**2 + vy**2)  # of the passing distance
    passing = Fraction(math.sqrt(square))
    return float((diameter**2 - square) / (diameter * (diameter + passing)))


def curved_depth(scene: Scene) -> float:
    """Return the same of a bent path, in 50 digits."""
    cue, other = scene.balls
    with workdps(_DIGITS):
        path = _path(cue, scene.physics)
        px, py = mpf(other.position[0]), mpf(other.position[1])

        def nearness(t: mpf) -> mpf:
            x, y = path(t)
            return -((x - px) ** 2 + (y - py) ** 2)

        nearest = mp.sqrt(-_peak(nearness, WAY / SPEED))
        diameter = mpf(cue.radius) + mpf(other.radius)
        return float((diameter - nearest) / diameter)


def cushion_depth(scene: Scene) -> float:
    """Return how far the ball would reach into the cushion at the top, in diameters, likewise."""
    (cue,) = scene.balls
    assert scene.table is not None
    with workdps(_DIGITS):
        path = _path(cue, scene.physics)
        apex = _peak(lambda t: path(t)[1], 0.4 * SPEED / (0.4 * 9.81))
        beyond = apex + mpf(cue.radius) - mpf(scene.table.width)
        return float(beyond / (2 * mpf(cue.radius)))


def _path(cue: Ball, physics: Physics) -> Callable[[Any], tuple[mpf, mpf]]:
    """Return the centre of a sliding ball against time: a parabola."""
    assert cue.angular_velocity is not None
    r, (vx, vy), (wx, wy) = (
        mpf(cue.radius),
        map(mpf, cue.velocity[:2]),
        map(mpf, cue.angular_velocity[:2]),
    )
    ux, uy = vx - r * wy, vy + r * wx
    pull = mpf(physics.sliding_friction) * mpf(physics.gravity) / mp.hypot(ux, uy)
    x0, y0 = map(mpf, cue.position[:2])

    def path(t: Any) -> tuple[mpf, mpf]:
        return x0 + vx * t - pull * ux * t**2 / 2, y0 + vy * t - pull * uy * t**2 / 2

    return path


def _peak(height: Callable[[Any], mpf], near: float) -> mpf:
    """Return the greatest value of a smooth function, whose peak is near an instant."""
    return height(mp.findroot(lambda t: mp.diff(height, t), near))


@dataclass(frozen=True)
class HitOrMiss:
    """Whether there is one collision where the path goes deep enough, and none where it doesn't.

    Attributes
    ----------
    depth : float
        In diameters; negative where nothing must collide.
    kind : EventKind
        Of the collision.
    """

    depth: float
    kind: EventKind = EventKind.BALL_BALL

    def __call__(self, result: Result) -> Verdict:
        """Judge a run."""
        assert result.events is not None
        collisions = int(np.count_nonzero(result.events["kind"] == self.kind))
        faults = []
        if self.depth > 0.0 and not collisions:
            faults.append(f"a collision {self.depth:.2e} diameters deep is missed")
        if self.depth < 0.0 and collisions:
            faults.append(
                f"a collision is seen where the path misses by {-self.depth:.2e} diameters"
            )
        if collisions > 1:
            faults.append(f"{collisions} collisions where there is one")
        # The deeper, the worse to get wrong; the shallower, the harder to get right.
        size = -math.log10(abs(self.depth)) / (SHALLOWEST + 1)
        severity = 2.0 - size if faults else size
        return Verdict.of(
            result.scene, faults, severity, {"depth": self.depth, "missed": bool(faults)}
        )


def _trials(suite: Suite) -> Iterator[Trial]:
    turns = (0.0, 0.7) if suite == "quick" else (0.0, 0.3, 0.7, 1.1, 2.3, 4.0)
    powers = range(1, SHALLOWEST + 1, 3 if suite == "quick" else 1)
    sliding = Physics(preset="pool")
    kinds: dict[str, tuple[Callable[[str, float, float], Scene], Callable[[Scene], float]]] = {
        "rolling": (lambda n, d, a: straight(n, Physics(), d, a), straight_depth),
        "elastic": (
            lambda n, d, a: straight(n, Physics(rolling_friction=0.0), d, a),
            straight_depth,
        ),
        "sliding": (lambda n, d, a: straight(n, sliding, d, a), straight_depth),
        "small": (lambda n, d, a: straight(n, sliding, d, a, 0.25), straight_depth),
        "curved": (curved, curved_depth),
        "cushion": (at_cushion, cushion_depth),
    }
    for kind, (make, depth_of) in kinds.items():
        for power in powers:
            for turn in turns[:1] if kind == "cushion" else turns:
                for sign, word in ((1.0, "hit"), (-1.0, "miss")):
                    name = f"{kind}-{word}-1e-{power:02d}" + (f"-turned-{turn:g}" if turn else "")
                    scene = make(name, sign * 10.0**-power, turn)
                    judge = HitOrMiss(
                        depth_of(scene),
                        EventKind.BALL_CUSHION if kind == "cushion" else EventKind.BALL_BALL,
                    )
                    yield SceneTrial(name, scene, judge, "events")


FAMILY = Family(
    "grazing",
    "Grazing hits and near misses",
    "A path that goes 1e-1 to 1e-13 of a diameter into a ball or a cushion gives one "
    "collision; one that stays as far away gives none.",
    _trials,
)
