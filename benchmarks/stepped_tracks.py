"""Simulate tracks with known physics by a program that shares no code with the engine or the fit.

Balls move in steps of 0.1 ms. The laws are implemented independently: friction of the cloth,
Coulomb friction between balls, and Han's cushion (Han 2005) with a nose height that can be chosen.
The errors of the camera differ from those in `synthetic_tracks`: heavy-tailed, correlated noise,
and rounding to pixels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from ghostball.model.arrays import FloatArray
from ghostball.validation.measured.tracks import Shots, Surface, Track

_DT = 1e-4
_GRAVITY = 9.81
_SPIN_RATE = 10.0  # deceleration of spin about the vertical [rad/s^2]
_LONGEST = 12.0  # [s]


@dataclass(frozen=True)
class SteppedTable:
    """The physics of a table; units as in `Physics`."""

    rolling_friction: float
    sliding_friction: float
    ball_restitution: float
    ball_friction: float
    cushion_restitution: float
    cushion_friction: float
    nose_height: float


@dataclass(frozen=True)
class Camera:
    """The errors of a camera.

    `rate` [1/s]: pictures per second.
    `noise` [m]: standard deviation of a coordinate.
    `drift`: correlation of the noise in successive pictures.
    `pixel` [m]: size of a pixel.
    `stale`: share of pictures that repeat the position of the picture before.
    """

    rate: float = 50.0
    noise: float = 8e-4
    drift: float = 0.5
    pixel: float = 5e-4
    stale: float = 0.02


def stepped_tracks(
    table: SteppedTable, surface: Surface, shots: int, seed: int, camera: Camera, *, side: float
) -> Shots:
    """Return tracks of random shots of three balls; half of the shots are aimed at a ball.

    `side`: standard deviation of the side spin, see `start_of`.
    """
    numbers = np.array(
        [
            *(table.rolling_friction, table.sliding_friction, table.ball_restitution),
            *(table.ball_friction, table.cushion_restitution, table.cushion_friction),
            *(table.nose_height, surface.length, surface.width, surface.radius),
        ]
    )
    every = round(1.0 / (camera.rate * _DT))
    found: Shots = {}
    for shot in range(1, shots + 1):
        state = start_of(shot, surface, seed, side=side)
        random = np.random.default_rng([seed, shot, 8])
        pictures = np.empty((int(_LONGEST * camera.rate) + 1, 3, 2))
        count = int(_play(state, numbers, every, pictures))
        times = np.arange(count) / camera.rate
        found[str(shot)] = {
            name: Track(times, _seen(random, pictures[:count, ball], camera))
            for ball, name in enumerate(("cue", "red", "yellow"))
        }
    return found


def start_of(shot: int, surface: Surface, seed: int, *, side: float) -> FloatArray:
    """Return the initial state of a shot of three balls, (3, 7): x, y, vx, vy, spin about x, y, z.

    Units: [m], [m/s], [rad/s].

    `side`: standard deviation of the side spin of the cue ball, R w_z / v, in half of the shots;
        the other shots have no side spin.
    """
    random = np.random.default_rng([seed, shot, 7])
    while True:
        places = random.uniform(0.12, (surface.length - 0.12, surface.width - 0.12), (3, 2))
        apart = [np.linalg.norm(places[i] - places[j]) for i, j in ((0, 1), (0, 2), (1, 2))]
        if min(apart) > 0.15:
            break
    angle = random.uniform(0.0, 2.0 * math.pi)
    if random.random() < 0.5:
        way = places[1] - places[0]
        angle = math.atan2(way[1], way[0]) + random.normal() * 0.04 / float(np.hypot(*way))
    speed, spin = random.uniform(0.6, 2.8), random.normal() * random.choice([0.0, side])
    state = np.zeros((3, 7))
    state[:, :2] = places
    vx, vy = speed * math.cos(angle), speed * math.sin(angle)
    roll = random.uniform(0.0, 1.0)
    state[0, 2:] = (
        *(vx, vy),
        *(-roll * vy / surface.radius, roll * vx / surface.radius, spin * speed / surface.radius),
    )
    return state


def _seen(random: np.random.Generator, places: FloatArray, camera: Camera) -> FloatArray:
    """Return the positions (n, 2) [m] as the camera records them."""
    fresh = random.standard_t(4.0, places.shape) * camera.noise / math.sqrt(2.0)
    noise = np.empty_like(fresh)
    last = fresh[0]
    for k, one in enumerate(fresh):
        last = camera.drift * last + math.sqrt(1.0 - camera.drift**2) * one if k else one
        noise[k] = last
    seen = np.round((places + noise) / camera.pixel) * camera.pixel
    stale = random.random(len(seen)) < camera.stale
    for k in range(1, len(seen)):
        if stale[k]:
            seen[k] = seen[k - 1]
    return seen


@njit(cache=False)
def _play(state, numbers, every, pictures):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Simulate a shot with time steps, and fill `pictures` every `every` steps; return the count.

    `state` (3, 7) is modified in place; `numbers` are the coefficients and sizes.
    """
    roll, slide, e_ball, mu_ball, e_cushion, mu_cushion, height, length, width, radius = numbers
    sine = (height - radius) / radius
    cosine = math.sqrt(1.0 - sine * sine)
    count, step = 0, 0
    while count < len(pictures):
        if step % every == 0:
            for ball in range(3):
                pictures[count, ball, 0] = state[ball, 0]
                pictures[count, ball, 1] = state[ball, 1]
            count += 1
        step += 1
        moving = False
        for ball in range(3):
            x, y, vx, vy, wx, wy, wz = state[ball]
            ux, uy = vx - radius * wy, vy + radius * wx  # velocity of the lowest point
            slip, speed = math.hypot(ux, uy), math.hypot(vx, vy)
            if slip > 3.5 * slide * _GRAVITY * _DT:
                ax, ay = -slide * _GRAVITY * ux / slip, -slide * _GRAVITY * uy / slip
                x += vx * _DT + 0.5 * ax * _DT * _DT
                y += vy * _DT + 0.5 * ay * _DT * _DT
                vx += ax * _DT
                vy += ay * _DT
                wx += 2.5 / radius * ay * _DT
                wy -= 2.5 / radius * ax * _DT
                moving = True
            elif speed > roll * _GRAVITY * _DT:
                if slip > 0.0:  # the rest of the slip ends within this step
                    vx -= 2.0 / 7.0 * ux
                    vy -= 2.0 / 7.0 * uy
                    speed = math.hypot(vx, vy)
                less = roll * _GRAVITY * _DT
                x += vx * (1.0 - 0.5 * less / speed) * _DT
                y += vy * (1.0 - 0.5 * less / speed) * _DT
                vx *= 1.0 - less / speed
                vy *= 1.0 - less / speed
                wx, wy = -vy / radius, vx / radius
                moving = True
            else:
                vx = vy = wx = wy = 0.0
            lost = _SPIN_RATE * _DT
            wz = 0.0 if abs(wz) <= lost else wz - math.copysign(lost, wz)
            state[ball, 0], state[ball, 1], state[ball, 2], state[ball, 3] = x, y, vx, vy
            state[ball, 4], state[ball, 5], state[ball, 6] = wx, wy, wz
        for ball in range(3):
            for side in range(4):
                # The axes of the cushion: n into it, t along it, 90 degrees left of n.
                nx, ny = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[side]
                far = length if side == 0 else width if side == 1 else 0.0
                place = state[ball, 0] * nx + state[ball, 1] * ny
                vn = state[ball, 2] * nx + state[ball, 3] * ny
                if place > far - radius and vn > 0.0:
                    vt = -state[ball, 2] * ny + state[ball, 3] * nx
                    wn = state[ball, 4] * nx + state[ball, 5] * ny
                    wt = -state[ball, 4] * ny + state[ball, 5] * nx
                    wz = state[ball, 6]
                    # The point of the ball at the nose is at R (cos, 0, sin) in (n, t, z); d is the
                    # direction (sin, 0, -cos) across it. Its velocity is v + w x r.
                    closing = vn * cosine
                    slip_d = vn * sine + radius * wt
                    slip_t = vt + radius * (wz * cosine - wn * sine)
                    slip = math.hypot(slip_d, slip_t)
                    push = (1.0 + e_cushion) * closing
                    rub = min(mu_cushion * push, 2.0 / 7.0 * slip)
                    jd = -rub * slip_d / slip if slip > 0.0 else 0.0
                    jt = -rub * slip_t / slip if slip > 0.0 else 0.0
                    vn += -push * cosine + jd * sine
                    vt += jt
                    # w gains (5/2R) r/R x J, J = jd d + jt t; the push goes through the centre.
                    wn += 2.5 / radius * (-sine * jt)
                    wt += 2.5 / radius * jd
                    wz += 2.5 / radius * (cosine * jt)
                    vn = min(vn, 0.0)
                    state[ball, 2], state[ball, 3] = vn * nx - vt * ny, vn * ny + vt * nx
                    state[ball, 4], state[ball, 5] = wn * nx - wt * ny, wn * ny + wt * nx
                    state[ball, 6] = wz
        for a, b in ((0, 1), (0, 2), (1, 2)):
            dx, dy = state[b, 0] - state[a, 0], state[b, 1] - state[a, 1]
            apart = math.hypot(dx, dy)
            nx, ny = dx / apart, dy / apart
            rvx, rvy = state[a, 2] - state[b, 2], state[a, 3] - state[b, 3]
            closing = rvx * nx + rvy * ny
            if apart < 2.0 * radius and closing > 0.0:
                # Slip of a on b at the contact, horizontal and vertical.
                spin_n = -(state[a, 4] + state[b, 4]) * ny + (state[a, 5] + state[b, 5]) * nx
                level = -rvx * ny + rvy * nx + radius * (state[a, 6] + state[b, 6])
                up = -radius * spin_n
                slip = math.hypot(level, up)
                push = 0.5 * (1.0 + e_ball) * closing
                rub = min(mu_ball * push, slip / 7.0)
                jl = -rub * level / slip if slip > 0.0 else 0.0
                ju = -rub * up / slip if slip > 0.0 else 0.0
                jx, jy = -push * nx - jl * ny, -push * ny + jl * nx
                state[a, 2] += jx
                state[a, 3] += jy
                state[b, 2] -= jx
                state[b, 3] -= jy
                # r x J, r = R n for a and -R n for b, whose impulse is the opposite: the same gain.
                gain = 2.5 / radius
                for ball in (a, b):
                    state[ball, 4] += gain * ny * ju
                    state[ball, 5] -= gain * nx * ju
                    state[ball, 6] += gain * jl
        if not moving:
            break
    return count
