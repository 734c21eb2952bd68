"""Which coefficient of the physics an engine plays with, where it plays with a wrong one.

    >>> found = wrong_factor(known, result)
    >>> found.what, found.value, found.right
    ('rolling_friction', 0.0142857, 0.02)

Our engine plays the scene again and again, one coefficient at a time scaled until its motion is
that of the engine. The one whose scaled shot comes nearest is named where it leaves a fraction of
the difference; where others do nearly as well, the shot can't tell them apart, and says so.

A shot that is played with a wrong coefficient soon becomes another shot, to which the way is no
smooth function of the coefficient any more. So the search begins on the first stretch, where the
engine is half a ball off the truth, and follows the best value from there to the end.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Final

import numpy as np

from ghostball.model import Ball, GhostballError, Result, Scene
from ghostball.model.arrays import FloatArray
from ghostball.validation.runs.playing import run_ours
from ghostball.validation.truth.known_shot import KnownShot, farthest

COEFFICIENTS: Final = (
    "rolling_friction",
    "sliding_friction",
    "spinning_friction_rate",
    "ball_restitution",
    "ball_friction",
    "cushion_restitution",
    "cushion_tangential_restitution",
    "cushion_friction",
    "cushion_restitution_loss",
    "rolling_friction_quadratic",
    "air_drag",
    "table_restitution",
)
"""Fields of the physics that are scaled, where they are numbers other than 0."""

ON_THE_WAY: Final = (*COEFFICIENTS[:3], "rolling_friction_quadratic", "air_drag")
"""Coefficients that act between contacts, not at contacts."""

MASS, SPIN, VERTICAL_SPIN = "mass", "spin", "vertical spin"

MOST_BALLS: Final = 4
"""Balls up to which the mass of each is scaled: among more, a mass is nothing one searches by."""

SCALES: Final = np.unique(
    [0.0, 1.0, *np.geomspace(0.1, 10.0, 41), 2 / 7, 2 / 5, 5 / 7, 7 / 5, 5 / 2, 7 / 2]
)
"""Where the search looks first."""

TIMES: Final = 161
"""Instants at which two motions are compared."""

VISIBLE: Final = 0.5
"""How far off the truth a ball is where the first stretch ends, in radii."""

STRETCH: Final = 2.0
"""How many times longer each stretch is than the one before."""

LEAVES: Final = 0.05
"""A factor is named if it leaves at most this share of the difference."""

RIVAL: Final = 2.0
"""Another one is named where it leaves at most so many times what the best one leaves."""

ROUND: Final = 0.004
"""How near a factor is to a simple one, as a share, to be called that."""

SIMPLE: Final = 10
"""Largest numerator and denominator of a simple factor."""

LEAST: Final = 1e-5
"""A difference below this is no wrong factor's to search for [m]."""

CLEAR: Final = 10.0
"""A first stretch that ends where collisions differ must show so many times `LEAST`."""

DISTINCT: Final = 3.0
"""The right value explains the motion no more where it is so many times farther off."""

_GOLDEN: Final = (math.sqrt(5.0) - 1.0) / 2.0


@dataclass(frozen=True)
class Factor:
    """A coefficient that an engine plays with, in place of the right one.

    `what`: a field of the physics, or "mass", "spin" or "vertical spin" of a ball.
    `ball`: whose; "" of all.
    `right`: what the scene says; 1 for a spin, which has several numbers.
    `value`: what the engine plays with.
    `before`, `after` [m]: the largest distance of a ball, within `until` [s], of the engine's
        motion from that with the right value, and from that with `value`.
    `since` [s]: the last instant until which the right value explains the motion as well.
    `rivals`: what else would explain it as well.
    `curve`: instants [s], and how far the engine is then from the truth, and from that [m].
    """

    what: str
    ball: str
    right: float
    value: float
    before: float
    after: float
    until: float
    since: float = 0.0
    rivals: tuple[str, ...] = ()
    curve: tuple[tuple[float, float, float], ...] = ()

    @property
    def name(self) -> str:
        """What it is, as a sentence calls it."""
        whose = f' of "{self.ball}"' if self.ball else ""
        return f"`{self.what}`{whose}" if self.what in COEFFICIENTS else f"the {self.what}{whose}"

    @property
    def scale(self) -> float:
        """The value over the right one."""
        return self.value / self.right

    @property
    def acts_on_the_way(self) -> bool:
        """Whether the coefficient has no effect at contacts."""
        return self.what in ON_THE_WAY or self.what.endswith("spin")

    @property
    def is_simple(self) -> bool:
        """Whether the two values are related as somebody would mistake one for the other."""
        return "." not in self.relation

    @property
    def relation(self) -> str:
        """How the two values are related, where that is simple: "5/7 of", "the square of"."""
        scale, right = self.scale, self.right
        if abs(scale) < ROUND:
            return "none of"
        if self.what.endswith("restitution") and right < 1.0:
            if abs(self.value - 1.0) < ROUND:
                return "elastic, not"
            for power, words in ((2.0, "the square of"), (0.5, "the root of")):
                if abs(self.value / right**power - 1.0) < ROUND:
                    return words
        simple = Fraction(scale).limit_denominator(SIMPLE)
        if simple.numerator <= SIMPLE and abs(scale / float(simple) - 1.0) < ROUND:
            times = simple.denominator == 1
            return f"{simple.numerator} times" if times else f"{simple} of"
        return f"{scale:.3g} times"


@dataclass(frozen=True)
class _Knob:
    """A coefficient that can be scaled, and the scene that comes of it."""

    what: str
    ball: str
    right: float
    largest: float
    scaled: Callable[[float], Scene]


def wrong_factor(known: KnownShot, result: Result, agreed: float | None = None) -> Factor | None:
    """Return the coefficient with which an engine's run is explained; None where none explains it.

    `result`: with its motion.
    `agreed` [s]: until when its collisions are the true ones; None: to the end.

    Balls are compared in the plane, until the engine's run ends.
    """
    scene = known.scene.without_strikes()
    try:
        search = _Search(known, result, agreed)
    except GhostballError:
        return None
    if search.before(search.ends[-1]) < LEAST:
        return None
    found = [(one, knob) for knob in _knobs(scene) if (one := search.fit(knob)) is not None]
    found.sort(key=lambda pair: (max(pair[0].after, LEAST), not pair[0].is_simple))
    if not found:
        return None
    best = search.with_curve(*found[0])
    rivals = tuple(
        f"{one.name} were {one.value:.4g}"
        for one, _ in found[1:]
        if one.until == best.until and one.after <= max(RIVAL * best.after, LEAST)
    )
    return replace(best, rivals=rivals)


class _Search:
    """The engine's motion, and how far our motions are from it."""

    def __init__(self, known: KnownShot, result: Result, agreed: float | None) -> None:
        self._result, self._known = result, known
        end = result.rest_time
        times = np.linspace(0.0, end, TIMES)
        off = farthest(result, known.result, times)
        seen = np.flatnonzero(off > VISIBLE * float(np.min(known.scene.radii)))
        first = float(times[seen[0]]) if len(seen) else end
        if agreed is not None and 0.0 < agreed < first and self.before(agreed) > CLEAR * LEAST:
            first = agreed  # what a break makes of a factor afterwards is no smooth function of it
        self.ends = [first]
        while self.ends[-1] < end:
            self.ends.append(min(STRETCH * self.ends[-1], end))

    def before(self, end: float) -> float:
        """Return how far the engine is from the truth, at most, until an instant [m]."""
        return float(np.max(farthest(self._result, self._known.result, _instants(end))))

    def fit(self, knob: _Knob) -> Factor | None:
        """Return the value that explains the engine's motion best; None where none explains it."""
        first = self.ends[0]
        scales = np.unique(np.minimum(SCALES, knob.largest))
        errors = np.array([self._error(knob, scale, first) for scale in scales])
        k = int(np.argmin(errors))
        if not np.any(errors[np.isfinite(errors)] > errors[k]):
            return None  # nothing in this shot depends on it
        # A factor of 0.95 lies between two scales, of which 1 may well be the nearest.
        low, high = scales[max(k - 1, 0)], scales[min(k + 1, len(scales) - 1)]
        nearest = self._least(knob, float(low), float(high), first)
        if not self._error(knob, nearest, first) < 0.7 * self._error(knob, 1.0, first):
            return None
        best: tuple[float, float] | None = None  # scale, until
        for end in self.ends:
            scale = self._least(knob, float(low), float(high), end)
            after, before = self._farthest(knob, scale, end), self.before(end)
            if not after <= LEAVES * before:
                break
            best = scale, end
            narrow = 0.03 * max(scale, 0.01)
            low, high = max(scale - narrow, 0.0), min(scale + narrow, knob.largest)
        if best is None:
            return None
        scale, end = best
        after, before = self._farthest(knob, scale, end), self.before(end)
        return Factor(knob.what, knob.ball, knob.right, scale * knob.right, before, after, end)

    def with_curve(self, found: Factor, knob: _Knob) -> Factor:
        """Return a factor with how far off both motions are, and since when the right one is."""
        first, whole = (self._both(found, knob, end) for end in (self.ends[0], found.until))
        apart = np.flatnonzero(first[:, 1] > DISTINCT * first[:, 2] + LEAST)
        since = float(first[max(int(apart[0]) - 1, 0), 0]) if len(apart) else 0.0
        rows = tuple((float(t), float(a), float(b)) for t, a, b in whole)
        return replace(found, since=since, curve=rows)

    def _both(self, found: Factor, knob: _Knob, end: float) -> FloatArray:
        """Return instants until one, and how far off the truth and ours are then: (k, 3)."""
        times, ours = _instants(end), self._off(knob, found.scale, end)
        assert ours is not None  # it was found so
        true = farthest(self._result, self._known.result, times)
        return np.column_stack([times, true, ours])

    def _least(self, knob: _Knob, low: float, high: float, end: float) -> float:
        """Return the scale with the least error between two (golden section)."""
        a, b = low, high
        c, d = b - _GOLDEN * (b - a), a + _GOLDEN * (b - a)
        at_c, at_d = self._error(knob, c, end), self._error(knob, d, end)
        while b - a > 1e-5 * max(b, 1e-3):
            if at_c < at_d:
                b, d, at_d = d, c, at_c
                c = b - _GOLDEN * (b - a)
                at_c = self._error(knob, c, end)
            else:
                a, c, at_c = c, d, at_d
                d = a + _GOLDEN * (b - a)
                at_d = self._error(knob, d, end)
        ends = [(self._error(knob, one, end), one) for one in (low, 0.5 * (a + b), high)]
        return min(ends)[1]

    def _error(self, knob: _Knob, scale: float, end: float) -> float:
        """Return the root mean square distance of the engine's balls from ours [m]."""
        off = self._off(knob, scale, end)
        return math.inf if off is None else float(np.sqrt(np.mean(off**2)))

    def _farthest(self, knob: _Knob, scale: float, end: float) -> float:
        off = self._off(knob, scale, end)
        return math.inf if off is None else float(np.max(off))

    def _off(self, knob: _Knob, scale: float, end: float) -> FloatArray | None:
        try:
            ours = run_ours(knob.scaled(scale).model_copy(update={"t_max": end}))
        except GhostballError:  # a value that a rule of scenes refuses
            return None
        if ours.rest_time < end and not ours.status.complete:
            return None
        return farthest(self._result, ours, _instants(end))


def _instants(end: float) -> FloatArray:
    return np.linspace(0.0, end, TIMES)


def _knobs(scene: Scene) -> Iterator[_Knob]:
    """Yield what of a scene can be scaled."""
    physics = scene.physics
    for name in COEFFICIENTS:
        right = getattr(physics, name)
        if isinstance(right, float | int) and right > 0.0:
            largest = 1.0 / right if "restitution" in name and "loss" not in name else math.inf
            yield _Knob(name, "", float(right), largest, _with_physics(scene, name, float(right)))
    several = 1 < len(scene.balls) <= MOST_BALLS
    for k, ball in enumerate(scene.balls):
        if several:
            yield _Knob(MASS, ball.id, ball.mass, math.inf, _with_ball(scene, k, _heavier))
        if physics.motion == "sliding" and scene.angular_velocities[k].any():
            yield _Knob(SPIN, ball.id, 1.0, math.inf, _with_ball(scene, k, _spinning))
            if scene.angular_velocities[k, 2] and scene.angular_velocities[k, :2].any():
                turning = _with_ball(scene, k, _turning)
                yield _Knob(VERTICAL_SPIN, ball.id, 1.0, math.inf, turning)


def _with_physics(scene: Scene, name: str, right: float) -> Callable[[float], Scene]:
    def scaled(scale: float) -> Scene:
        physics = scene.physics.model_copy(update={name: scale * right})
        return scene.model_copy(update={"physics": physics})

    return scaled


def _with_ball(
    scene: Scene, index: int, change: Callable[[Ball, FloatArray, float], Ball]
) -> Callable[[float], Scene]:
    spin = scene.angular_velocities[index]

    def scaled(scale: float) -> Scene:
        balls: Sequence[Ball] = [
            change(ball, spin, scale) if k == index else ball for k, ball in enumerate(scene.balls)
        ]
        return scene.model_copy(update={"balls": tuple(balls)})

    return scaled


def _heavier(ball: Ball, _: FloatArray, scale: float) -> Ball:
    return ball.model_copy(update={"mass": max(scale, 1e-3) * ball.mass})


def _spinning(ball: Ball, spin: FloatArray, scale: float) -> Ball:
    return ball.model_copy(update={"angular_velocity": tuple((scale * spin).tolist())})


def _turning(ball: Ball, spin: FloatArray, scale: float) -> Ball:
    x, y, z = spin.tolist()
    return ball.model_copy(update={"angular_velocity": (x, y, scale * z)})
