"""Shots in flight by an integrator that isn't ours: scipy's DOP853, and laws written anew.

Motion between events is integrated numerically from its forces (Newton's and Euler's equations,
Coulomb friction at the lowest point, gravity); what meets is found on the dense output of each
step. Impacts are vectors: a normal impulse (1 + e) times what ends the approach, and friction
against the slip of the surfaces, at most mu times that and at most what ends the slip. They are
written from docs/physics.md, and call nothing of the engine or of the proofs. What these leave to a
rule of their own (balls that rest on others, contacts that hardly hop) ends the integration.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853
from scipy.optimize import brentq

from ghostball.engine import CUSHIONS, EventKind, Scene

Vector = NDArray[np.float64]

RTOL, ATOL = 1e-13, 1e-15
LONGEST_STEP = 0.05
"""Of the integrator [s]: where nothing bends, it would take steps in which balls meet and part."""

SAMPLES = 12
"""Looks at each gap in a step; between two looks it is followed where its rate changes sign."""

CAPTURE = 2.0**-18
LOWEST = 2.0**-24
"""Heights in diameters of docs/physics.md: below which an impact lifts nothing, and below which
bounces on the table are no events of their own."""

PHASE_ENDS = (EventKind.SLIDE_TO_ROLL, EventKind.ROLL_TO_REST)

AIR, SLIDE, ROLL, TAIL, REST, GONE = "air", "slide", "roll", "tail", "rest", "gone"

UP = np.array([0.0, 0.0, 1.0])
INWARD = {
    "left": np.array([1.0, 0.0, 0.0]),
    "right": np.array([-1.0, 0.0, 0.0]),
    "bottom": np.array([0.0, 1.0, 0.0]),
    "top": np.array([0.0, -1.0, 0.0]),
}


class NotFollowedError(Exception):
    """From here on a rule of the model that isn't integrated here decides."""


@dataclass
class Moving:
    """One ball, and the phase that it is in."""

    x: Vector
    v: Vector
    w: Vector
    phase: str
    along: Vector = field(default_factory=lambda: np.zeros(3))  # of slip or velocity, at the start
    ends: float = math.inf  # of a tail of low bounces [s]
    after: tuple[Vector, Vector] | None = None  # velocity and spin once it ends


@dataclass
class Integrated:
    """What happened: events as (t, kind, a, b), and how it ended."""

    events: list[tuple[float, int, int, int]]
    balls: list[Moving]
    t: float
    complete: bool


def integrate(scene: Scene, most: int = 2000) -> Integrated:
    """Play a shot whose balls may leave the cloth."""
    shot = _Shot(scene)
    try:
        while len(shot.events) < most and shot.go_on():
            pass
    except NotFollowedError:
        return Integrated(shot.events, shot.balls, shot.t, complete=False)
    return Integrated(shot.events, shot.balls, shot.t, complete=len(shot.events) < most)


class _Shot:
    def __init__(self, scene: Scene) -> None:
        self.scene, self.physics = scene, scene.physics
        self.g = scene.physics.gravity
        self.r, self.m = scene.radii, scene.masses
        self.n = len(self.r)
        self.mu_s, self.mu_r = scene.sliding_frictions, scene.rolling_frictions
        self.alpha = scene.spinning_friction_rates
        self.t = 0.0
        self.events: list[tuple[float, int, int, int]] = []
        self.balls = []
        for k in range(self.n):
            x, v, w = (
                a[k].copy() for a in (scene.positions, scene.velocities, scene.angular_velocities)
            )
            ball = Moving(x, v, w, AIR)
            if not (x[2] > self.r[k] or v[2] > 0.0):
                self._put_down(ball, k, rolls=bool(scene.rolls[k]))
            self.balls.append(ball)

    # -- motion ----------------------------------------------------------------------------------

    def _slip(self, ball: Moving, k: int) -> Vector:
        """Velocity of the lowest point, along the cloth."""
        u = ball.v + np.cross(ball.w, -self.r[k] * UP)
        return u * (1.0, 1.0, 0.0)

    def _put_down(self, ball: Moving, k: int, *, rolls: bool = False) -> None:
        """Let a ball go on along the cloth: it slides, rolls or rests."""
        ball.x[2], ball.v[2] = self.r[k], 0.0
        u = self._slip(ball, k)
        size = np.linalg.norm(u)
        if not rolls and size > 1e-13 * (
            np.linalg.norm(ball.v) + self.r[k] * np.linalg.norm(ball.w)
        ):
            ball.phase, ball.along = SLIDE, u / size
            return
        speed = np.linalg.norm(ball.v)
        ball.w[:2] = np.cross(UP, ball.v)[:2] / self.r[k]
        if speed == 0.0:
            ball.phase = REST
        else:
            ball.phase, ball.along = ROLL, ball.v / speed

    def _rates(self, _: float, y: Vector) -> Vector:
        rates = np.zeros((self.n, 9))
        for k, (ball, row) in enumerate(zip(self.balls, y.reshape(self.n, 9), strict=True)):
            v, w = row[3:6], row[6:9]
            if ball.phase in (REST, GONE):
                continue
            rates[k, :3] = v
            if ball.phase == AIR:
                rates[k, 5] = -self.g
            elif ball.phase == SLIDE:
                u = (v + np.cross(w, -self.r[k] * UP)) * (1.0, 1.0, 0.0)
                # On past the end of the slip, which is looked for on the dense output.
                way = u / np.linalg.norm(u) if u @ ball.along > 0.0 else ball.along
                force = -self.mu_s[k] * self.m[k] * self.g * way
                torque = np.cross(-self.r[k] * UP, force)
                rates[k, 3:6] = force / self.m[k]
                rates[k, 6:9] = torque / (0.4 * self.m[k] * self.r[k] ** 2)
            elif ball.phase == ROLL:
                way = v / np.linalg.norm(v) if v @ ball.along > 0.0 else ball.along
                rates[k, 3:6] = -self.mu_r[k] * self.g * way
                rates[k, 6:8] = np.cross(UP, rates[k, 3:6])[:2] / self.r[k]
        return rates.ravel()

    def _spun(self, ball: Moving, k: int, duration: float) -> float:
        """Spin about the vertical after a time, which the cloth slows and the air does not."""
        wz = float(ball.w[2])
        if ball.phase in (AIR, GONE):
            return wz
        return math.copysign(max(abs(wz) - self.alpha[k] * duration, 0.0), wz)

    # -- what may happen --------------------------------------------------------------------------

    def _functions(self) -> list[tuple[tuple[int, int, int], Callable[[Vector], float]]]:
        """Return what falls through 0 where something happens, of the state (n, 9)."""
        found: list[tuple[tuple[int, int, int], Callable[[Vector], float]]] = []
        for k, ball in enumerate(self.balls):
            if ball.phase in (REST, GONE):
                continue
            if ball.phase == AIR:
                found.append(
                    ((int(EventKind.BALL_CLOTH), k, -1), lambda y, k=k: y[k, 2] - self.r[k])
                )
            elif ball.phase == SLIDE:
                along = ball.along

                def slip(y: Vector, k: int = k, along: Vector = along) -> float:
                    return float((y[k, 3:6] + np.cross(y[k, 6:9], -self.r[k] * UP)) @ along)

                found.append(((int(EventKind.SLIDE_TO_ROLL), k, -1), slip))
            elif ball.phase == ROLL:
                found.append(
                    (
                        (int(EventKind.ROLL_TO_REST), k, -1),
                        lambda y, k=k, along=ball.along: float(y[k, 3:6] @ along),
                    )
                )
            found += self._noses(k)
        for i in range(self.n):
            for j in range(i + 1, self.n):
                phases = {self.balls[i].phase, self.balls[j].phase}
                if GONE in phases or phases == {REST}:
                    continue

                def gap(y: Vector, i: int = i, j: int = j) -> float:
                    return float(np.linalg.norm(y[j, :3] - y[i, :3]) - self.r[i] - self.r[j])

                found.append(((int(EventKind.BALL_BALL), i, j), gap))
        return found

    def _noses(self, k: int) -> list[tuple[tuple[int, int, int], Callable[[Vector], float]]]:
        found: list[tuple[tuple[int, int, int], Callable[[Vector], float]]] = []
        for side in self.scene.table.cushions if self.scene.table is not None else ():
            number = CUSHIONS.index(side)

            def away(y: Vector, k: int = k, side: str = side) -> float:
                return self._away(y[k, :3], side)

            def gap(y: Vector, k: int = k, side: str = side) -> float:
                above = y[k, 2] - self.physics.cushion_height
                return math.hypot(self._away(y[k, :3], side), above) - float(self.r[k])

            found.append(((int(EventKind.BALL_CUSHION), k, number), gap))
            if self.balls[k].phase == AIR:
                found.append(((int(EventKind.LEAVES_TABLE), k, number), away))
        return found

    def _away(self, x: Vector, side: str) -> float:
        table = self.scene.table
        assert table is not None
        line = {"left": 0.0, "right": -table.length, "bottom": 0.0, "top": -table.width}[side]
        return float(INWARD[side] @ x) - line

    def _state(self) -> Vector:
        return np.array([np.concatenate((b.x, b.v, b.w)) for b in self.balls])

    # -- one event --------------------------------------------------------------------------------

    def go_on(self) -> bool:
        """Integrate to the next event and resolve it; False where everything rests."""
        functions = self._functions()
        tails = [b.ends for b in self.balls if b.phase == TAIL]
        if not functions and not tails:
            return False
        start, y0 = self.t, self._state().ravel()
        horizon = min(tails, default=math.inf)
        now = self._immediate(functions)
        if now is not None:
            self._resolve(now)
            return True
        solver = DOP853(
            self._rates, start, y0, start + 1e3, max_step=LONGEST_STEP, rtol=RTOL, atol=ATOL
        )
        first = True
        while solver.status == "running":
            solver.step()
            if solver.status == "failed":
                raise NotFollowedError
            dense, low, high = solver.dense_output(), solver.t_old, min(solver.t, horizon)
            best: tuple[float, tuple[int, int, int]] | None = None
            times = np.linspace(low, high, SAMPLES + 1)
            states = dense(times).T.reshape(-1, self.n, 9)
            for key, function in functions:

                def at(t: float, f: Any = function, dense: Any = dense) -> float:
                    return float(f(dense(t).reshape(self.n, 9)))

                values = [function(y) for y in states]
                s = _first_fall(at, times, values, first and key[0] not in PHASE_ENDS)
                if s is not None and (best is None or s < best[0]):
                    best = (s, key)
            if best is None and high == horizon:
                k = next(k for k, b in enumerate(self.balls) if b.ends == horizon)
                best = (horizon, (int(EventKind.BALL_CLOTH), k, -1))
            if best is not None:
                t, key = best
                self._move_to(t, dense(t).reshape(self.n, 9))
                self._resolve(key)
                return True
            first = False
        raise NotFollowedError

    def _immediate(
        self, functions: list[tuple[tuple[int, int, int], Callable[[Vector], float]]]
    ) -> tuple[int, int, int] | None:
        """Return what touches and approaches right now, after an event of this instant."""
        y = self._state()
        h = 1e-9
        later = y + h * self._rates(0.0, y.ravel()).reshape(self.n, 9)
        for key, function in functions:
            if key[0] in (EventKind.BALL_BALL, EventKind.BALL_CUSHION):
                gap = function(y)
                rate = (function(later) - gap) / h
                if abs(gap) < 1e-11 and rate < -1e-6:
                    return key
        return None

    def _move_to(self, t: float, y: Vector) -> None:
        for k, (ball, row) in enumerate(zip(self.balls, y, strict=True)):
            if ball.phase in (REST, GONE):
                ball.w[2] = self._spun(ball, k, t - self.t)
                continue
            wz = self._spun(ball, k, t - self.t)
            ball.x, ball.v, ball.w = row[:3].copy(), row[3:6].copy(), row[6:9].copy()
            ball.w[2] = wz
            if ball.phase != AIR:
                ball.x[2], ball.v[2] = self.r[k], 0.0
        self.t = t

    def _resolve(self, key: tuple[int, int, int]) -> None:
        kind, a, b = key
        ball = self.balls[a]
        if kind == EventKind.SLIDE_TO_ROLL:
            if np.linalg.norm(ball.v) < 1e-11:
                kind, ball.v = int(EventKind.ROLL_TO_REST), np.zeros(3)
            self._put_down(ball, a, rolls=True)
        elif kind == EventKind.ROLL_TO_REST:
            ball.v = np.zeros(3)
            self._put_down(ball, a, rolls=True)
        elif kind == EventKind.LEAVES_TABLE:
            ball.phase, ball.v, ball.w = GONE, np.zeros(3), np.zeros(3)
        elif kind == EventKind.BALL_CLOTH:
            if ball.phase == TAIL:
                assert ball.after is not None
                (ball.v, spin), ball.ends = ball.after, math.inf
                ball.w[:2], ball.after = spin[:2], None
                self._put_down(ball, a)
            else:
                ball.x[2] = self.r[a]
                self._answer(ball, a)
        elif kind == EventKind.BALL_CUSHION:
            self._bounce(a, CUSHIONS[b])
        else:
            self._collide(a, b)
        self.events.append((self.t, int(kind), a, b))

    # -- impacts ----------------------------------------------------------------------------------

    def _push(self, k: int, impulse: Vector, arm: Vector) -> None:
        """Give ball k an impulse at a point, `arm` from its centre."""
        ball = self.balls[k]
        ball.v = ball.v + impulse / self.m[k]
        ball.w = ball.w + np.cross(arm, impulse) / (0.4 * self.m[k] * self.r[k] ** 2)

    def _slow(self, diameter: float) -> float:
        return math.sqrt(2.0 * self.g * CAPTURE * diameter)

    def _collide(self, i: int, j: int) -> None:
        a, b = self.balls[i], self.balls[j]
        free = AIR in (a.phase, b.phase)
        n = b.x - a.x
        n = n / np.linalg.norm(n)
        relative = a.v - b.v
        speed = float(relative @ n)
        slow = self._slow(float(self.r[i] + self.r[j]))
        if speed <= slow:
            raise NotFollowedError
        returned = self.physics.ball_restitution * speed
        returned = max(returned, slow) if free else returned
        reduced = self.m[i] * self.m[j] / (self.m[i] + self.m[j])
        normal = reduced * (speed + returned)
        at_a, at_b = self.r[i] * n, -self.r[j] * n
        slip = relative - speed * n + np.cross(a.w, at_a) - np.cross(b.w, at_b)
        size = float(np.linalg.norm(slip))
        impulse = -normal * n
        if size > 0.0:
            mu = self.physics.ball_friction
            if mu == "alciatore":
                mu = 9.951e-3 + 0.108 * math.exp(-1.088 * size)
            # Two solid spheres: a tangential impulse J changes the slip by 7/2 J over the mass.
            impulse = impulse - min(float(mu) * normal, 2.0 / 7.0 * reduced * size) * slip / size
        self._push(i, impulse, at_a)
        self._push(j, -impulse, at_b)
        for k in (i, j):
            self._answer(self.balls[k], k)

    def _bounce(self, k: int, side: str) -> None:
        ball, physics = self.balls[k], self.physics
        free = ball.phase == AIR
        inward = INWARD[side]
        away, above = self._away(ball.x, side), ball.x[2] - physics.cushion_height
        n = -(inward * away + UP * above)
        n = n / np.linalg.norm(n)
        speed = float(ball.v @ n)
        slow = self._slow(2.0 * float(self.r[k]))
        if (speed if free else -float(ball.v @ inward)) <= slow:
            raise NotFollowedError
        e = 1.0 if physics.cushion == "mirror" else physics.cushion_restitution
        returned = max(e * speed, slow) if free else e * speed
        normal = self.m[k] * (speed + returned)
        impulse = -normal * n
        arm = self.r[k] * n
        if physics.cushion in ("frictional", "han2005"):
            slip = ball.v - speed * n + np.cross(ball.w, arm)
            size = float(np.linalg.norm(slip))
            if size > 0.0:
                most = 2.0 / 7.0 * self.m[k] * size
                impulse = impulse - min(physics.cushion_friction * normal, most) * slip / size
            self._push(k, impulse, arm)
        else:
            factor = 1.0 if physics.cushion == "mirror" else physics.cushion_tangential_restitution
            along = np.cross(UP, inward)
            ball.v = ball.v + impulse / self.m[k] - (1.0 - factor) * (ball.v @ along) * along
        self._answer(ball, k)

    def _answer(self, ball: Moving, k: int) -> None:
        """Let the table answer to a ball that lies on it."""
        ball.ends, ball.after = math.inf, None
        if ball.x[2] > self.r[k] + 1e-13:
            ball.phase = AIR
            return
        ball.x[2] = self.r[k]
        if ball.v[2] < -1e-15:
            self._land(ball, k)
        elif abs(ball.v[2]) <= 1e-15:
            ball.v[2] = 0.0
        up, e = float(ball.v[2]), self.physics.table_restitution
        if up * up > 2.0 * self.g * LOWEST * 2.0 * self.r[k]:
            ball.phase = AIR
            return
        if up == 0.0:
            self._put_down(ball, k)
            return
        # Impact by impact, on a copy, until nothing is left of them.
        last, lasts, x = replace(ball, v=ball.v.copy(), w=ball.w.copy()), 0.0, ball.x.copy()
        while last.v[2] > 1e-25:
            hop = 2.0 * last.v[2] / self.g
            lasts += hop
            x += hop * last.v * (1.0, 1.0, 0.0)
            last.v[2] *= -1.0
            self._land(last, k)
            if e == 0.0:
                break
        last.v[2] = 0.0
        ball.phase, ball.ends, ball.after = TAIL, self.t + lasts, (last.v, last.w)
        mean = (x - ball.x) / lasts
        # The same impulses that have slowed it have turned it.
        pushed = (mean - ball.v) * (1.0, 1.0, 0.0)
        ball.w = ball.w + np.cross(-self.r[k] * UP, pushed) / (0.4 * self.r[k] ** 2)
        ball.v = mean

    def _land(self, ball: Moving, k: int) -> None:
        down, e = -float(ball.v[2]), self.physics.table_restitution
        u = self._slip(ball, k)
        size = float(np.linalg.norm(u))
        ball.v[2] = e * down
        if size > 0.0:
            taken = min(self.mu_s[k] * (1.0 + e) * down, 2.0 / 7.0 * size)
            push = -taken * u / size
            ball.v = ball.v + push
            ball.w = ball.w + np.cross(-self.r[k] * UP, push) / (0.4 * self.r[k] ** 2)


def _first_fall(
    f: Callable[[float], float], times: Vector, values: Sequence[float], touches: bool
) -> float | None:
    """Return where a function first falls through 0 between `times`; None where it doesn't.

    Just after an event it may begin at 0, where something touches, and rise.
    """
    low, high = float(times[0]), float(times[-1])
    h = (high - low) * 1e-6

    def slope(t: float) -> float:
        return (f(min(t + h, high)) - f(max(t - h, low))) / (2.0 * h)

    for k in range(SAMPLES):
        t, later = float(times[k]), float(times[k + 1])
        before, after = values[k], values[k + 1]
        if touches and k == 0 and abs(before) < 1e-11:
            # It touches at the start: it has to rise before it can fall.
            early = f(t + h)
            if early <= 0.0 and early < before:
                return t
            if after > 0.0 or not early > 0.0:
                continue
            t, before = t + h, early
        if before > 0.0 >= after:
            return float(brentq(f, t, later, xtol=1e-16, rtol=4 * np.finfo(float).eps))
        if before > 0.0 and after > 0.0 and slope(t) < 0.0 < slope(later):
            lowest = float(brentq(slope, t, later, xtol=1e-12))
            if f(lowest) <= 0.0:
                return float(brentq(f, t, lowest, xtol=1e-16, rtol=4 * np.finfo(float).eps))
    return None
