"""Find the single coefficient whose wrong value explains the motion of an engine.

    >>> found = wrong_factor(known, result)
    >>> found.what, found.value, found.right
    ('rolling_friction', 0.0142857, 0.02)

Ghostball's engine simulates the scene repeatedly, scaling one coefficient at a time, to reproduce
the motion of the engine. The coefficient with the best match is reported if it leaves only a small
part of the difference. Coefficients with nearly as good a match are reported, too, because the shot
can't distinguish them.

With a wrong coefficient, collisions soon differ, and then the motion is no smooth function of the
coefficient. The search therefore starts with the first interval, until the engine is half a radius
from the reference, and follows the best value from there to the end.
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
from ghostball.validation.runs.engine_runs import run_ours
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
"""Fields of the physics that are scaled, if they are numbers other than 0."""

MOTION_COEFFICIENTS: Final = (*COEFFICIENTS[:3], "rolling_friction_quadratic", "air_drag")
"""Coefficients that act between contacts, not at contacts."""

MASS, SPIN, VERTICAL_SPIN = "mass", "spin", "vertical spin"

MOST_BALLS: Final = 4
"""Largest number of balls for which the mass of each is scaled."""

SCALES: Final = np.unique(
    [0.0, 1.0, *np.geomspace(0.1, 10.0, 41), 2 / 7, 2 / 5, 5 / 7, 7 / 5, 5 / 2, 7 / 2]
)
"""The scales that the search tries first."""

SAMPLE_COUNT: Final = 161
"""Number of times at which two motions are compared."""

VISIBLE_DISTANCE: Final = 0.5
"""Distance of a ball from the reference at which the first interval ends, in radii."""

STRETCH_RATIO: Final = 2.0
"""Ratio of the lengths of consecutive intervals."""

LARGEST_REMAINDER: Final = 0.05
"""A factor is reported if it leaves at most this share of the difference."""

RIVAL_RATIO: Final = 2.0
"""Another factor is reported if it leaves at most this many times the difference of the best one.
"""

SIMPLE_TOLERANCE: Final = 0.004
"""Largest relative deviation of a factor from a simple fraction."""

LARGEST_NUMERATOR: Final = 10
"""Largest numerator and denominator of a simple factor."""

LEAST_DIFFERENCE: Final = 1e-5
"""Differences below this aren't explained by a wrong factor [m]."""

CLEAR_RATIO: Final = 10.0
"""Least difference in a first interval that ends at a wrong collision, in units of
`LEAST_DIFFERENCE`."""

DISTINCT_RATIO: Final = 3.0
"""Ratio of the differences above which the right value no longer explains the motion."""

_GOLDEN: Final = (math.sqrt(5.0) - 1.0) / 2.0


@dataclass(frozen=True)
class Factor:
    """A coefficient with the value that an engine uses in place of the right one.

    `what`: a field of the physics, or "mass", "spin" or "vertical spin" of a ball.
    `ball`: its ball; "" for all balls.
    `right`: the value in the scene; 1 for a spin, which has several numbers.
    `value`: the value that the engine uses.
    `before`, `after` [m]: largest distance of a ball up to `until` [s] between the engine's motion
        and the motion with the right value (`before`) or with `value` (`after`).
    `since` [s]: time up to which the right value explains the motion, too.
    `rivals`: other factors that would explain the motion as well.
    `curve`: times [s], with the distances from the reference and from the motion with `value` [m].
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
        """The coefficient in the words of a sentence."""
        whose = f' of "{self.ball}"' if self.ball else ""
        return f"`{self.what}`{whose}" if self.what in COEFFICIENTS else f"the {self.what}{whose}"

    @property
    def scale(self) -> float:
        """The value divided by the right one."""
        return self.value / self.right

    @property
    def acts_on_the_way(self) -> bool:
        """Whether the coefficient has no effect at contacts."""
        return self.what in MOTION_COEFFICIENTS or self.what.endswith("spin")

    @property
    def is_simple(self) -> bool:
        """Whether the ratio of the values suggests a common mistake."""
        return "." not in self.relation

    @property
    def relation(self) -> str:
        """The ratio of the two values in words: "5/7 of", "the square of"."""
        scale, right = self.scale, self.right
        if abs(scale) < SIMPLE_TOLERANCE:
            return "none of"
        if self.what.endswith("restitution") and right < 1.0:
            if abs(self.value - 1.0) < SIMPLE_TOLERANCE:
                return "elastic, not"
            for power, words in ((2.0, "the square of"), (0.5, "the root of")):
                if abs(self.value / right**power - 1.0) < SIMPLE_TOLERANCE:
                    return words
        simple = Fraction(scale).limit_denominator(LARGEST_NUMERATOR)
        if (
            simple.numerator <= LARGEST_NUMERATOR
            and abs(scale / float(simple) - 1.0) < SIMPLE_TOLERANCE
        ):
            times = simple.denominator == 1
            return f"{simple.numerator} times" if times else f"{simple} of"
        return f"{scale:.3g} times"


@dataclass(frozen=True)
class _Knob:
    """A coefficient that can be scaled, and a function that returns the scaled scene."""

    what: str
    ball: str
    right: float
    largest: float
    scaled: Callable[[float], Scene]


def wrong_factor(known: KnownShot, result: Result, agreed: float | None = None) -> Factor | None:
    """Return the coefficient that explains an engine's run; None if there is none.

    `result`: with its motion.
    `agreed` [s]: time up to which its collisions agree with the reference; None: to the end.

    Horizontal positions are compared, until the engine's run ends.
    """
    scene = known.scene.without_strikes()
    try:
        search = _Search(known, result, agreed)
    except GhostballError:
        return None
    if search.before(search.ends[-1]) < LEAST_DIFFERENCE:
        return None
    found = [(one, knob) for knob in _knobs(scene) if (one := search.fit(knob)) is not None]
    found.sort(key=lambda pair: (max(pair[0].after, LEAST_DIFFERENCE), not pair[0].is_simple))
    if not found:
        return None
    best = search.with_curve(*found[0])
    rivals = tuple(
        f"{one.name} were {one.value:.4g}"
        for one, _ in found[1:]
        if one.until == best.until and one.after <= max(RIVAL_RATIO * best.after, LEAST_DIFFERENCE)
    )
    return replace(best, rivals=rivals)


class _Search:
    """The engine's motion, and its distances from simulated motions."""

    def __init__(self, known: KnownShot, result: Result, agreed: float | None) -> None:
        self._result, self._known = result, known
        end = result.rest_time
        times = np.linspace(0.0, end, SAMPLE_COUNT)
        off = farthest(result, known.result, times)
        seen = np.flatnonzero(off > VISIBLE_DISTANCE * float(np.min(known.scene.radii)))
        first = float(times[seen[0]]) if len(seen) else end
        if (
            agreed is not None
            and 0.0 < agreed < first
            and self.before(agreed) > CLEAR_RATIO * LEAST_DIFFERENCE
        ):
            first = agreed  # after a break, the motion is no smooth function of a factor
        self.ends = [first]
        while self.ends[-1] < end:
            self.ends.append(min(STRETCH_RATIO * self.ends[-1], end))

    def before(self, end: float) -> float:
        """Return the largest distance of the engine from the reference up to a time [m]."""
        return float(np.max(farthest(self._result, self._known.result, _instants(end))))

    def fit(self, knob: _Knob) -> Factor | None:
        """Return the value that explains the engine's motion best; None if none explains it."""
        first = self.ends[0]
        scales = np.unique(np.minimum(SCALES, knob.largest))
        errors = np.array([self._error(knob, scale, first) for scale in scales])
        k = int(np.argmin(errors))
        if not np.any(errors[np.isfinite(errors)] > errors[k]):
            return None  # the shot doesn't depend on this coefficient
        # A factor of 0.95 is between two scales, and the nearest may be 1.
        low, high = scales[max(k - 1, 0)], scales[min(k + 1, len(scales) - 1)]
        nearest = self._least(knob, float(low), float(high), first)
        if not self._error(knob, nearest, first) < 0.7 * self._error(knob, 1.0, first):
            return None
        best: tuple[float, float] | None = None  # scale, until
        for end in self.ends:
            scale = self._least(knob, float(low), float(high), end)
            after, before = self._farthest(knob, scale, end), self.before(end)
            if not after <= LARGEST_REMAINDER * before:
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
        """Return a factor with its curve, and the time from which the right value fails."""
        first, whole = (self._both(found, knob, end) for end in (self.ends[0], found.until))
        apart = np.flatnonzero(first[:, 1] > DISTINCT_RATIO * first[:, 2] + LEAST_DIFFERENCE)
        since = float(first[max(int(apart[0]) - 1, 0), 0]) if len(apart) else 0.0
        rows = tuple((float(t), float(a), float(b)) for t, a, b in whole)
        return replace(found, since=since, curve=rows)

    def _both(self, found: Factor, knob: _Knob, end: float) -> FloatArray:
        """Return times up to `end`, with the distances from reference and fit: (k, 3)."""
        times, ours = _instants(end), self._off(knob, found.scale, end)
        assert ours is not None  # `fit` has simulated it before
        true = farthest(self._result, self._known.result, times)
        return np.column_stack([times, true, ours])

    def _least(self, knob: _Knob, low: float, high: float, end: float) -> float:
        """Return the scale with the least error in an interval (golden section search)."""
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
        """Return the rms distance of the engine's balls from those of the scaled shot [m]."""
        off = self._off(knob, scale, end)
        return math.inf if off is None else float(np.sqrt(np.mean(off**2)))

    def _farthest(self, knob: _Knob, scale: float, end: float) -> float:
        off = self._off(knob, scale, end)
        return math.inf if off is None else float(np.max(off))

    def _off(self, knob: _Knob, scale: float, end: float) -> FloatArray | None:
        try:
            ours = run_ours(knob.scaled(scale).model_copy(update={"t_max": end}))
        except GhostballError:  # the value is invalid in a scene
            return None
        if ours.rest_time < end and not ours.status.complete:
            return None
        return farthest(self._result, ours, _instants(end))


def _instants(end: float) -> FloatArray:
    return np.linspace(0.0, end, SAMPLE_COUNT)


def _knobs(scene: Scene) -> Iterator[_Knob]:
    """Yield the coefficients of a scene that can be scaled."""
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
