"""Kernels for the closed form of cloth friction; numpy calls would be slow with so few balls.

Arguments, for n balls: v, velocities (n, 2) [m/s]; w, angular velocities (n, 3) [rad/s]; radii
(n,) [m]; decelerations, `rolls_by` and `slides_by` (n,) [m/s^2], `spins_by` (n,) [rad/s^2]; `dt`
[s]. The last argument is the output. `move` also changes v, and `turn` changes w.
`advance_within_phases` and `advance_steps` change v and w; `advance_steps` has three outputs.
Contract: no allocation.
"""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.model.arrays import BoolArray, FloatArray

SLOWEST = 1e-200
"""Speed below which a ball isn't slowed [m/s], because its direction would overflow."""


@kernel
def _slowing(speed: float, deceleration: float) -> float:
    """Return the acceleration of a ball over its velocity [1/s], at most 0."""
    return -deceleration / speed if speed > SLOWEST else 0.0


@kernel
def _duration(speed: float, deceleration: float) -> float:
    """Return how long a decelerating ball moves [s]: 0 at rest, inf without deceleration."""
    if deceleration > 0.0:
        return speed / deceleration
    return math.inf if speed > 0.0 else 0.0


@kernel(entry=True)
def slow(velocities: FloatArray, decelerations: FloatArray, accelerations: FloatArray) -> None:
    """Write the accelerations of balls that are slowed against their motion, (n, 2) [m/s^2]."""
    for i in range(len(decelerations)):
        factor = _slowing(math.hypot(velocities[i, 0], velocities[i, 1]), decelerations[i])
        for k in range(2):
            accelerations[i, k] = velocities[i, k] * factor


@kernel(entry=True)
def stop(velocities: FloatArray, decelerations: FloatArray, times: FloatArray) -> None:
    """Write how long each ball moves, (n,) [s]."""
    for i in range(len(decelerations)):
        times[i] = _duration(math.hypot(velocities[i, 0], velocities[i, 1]), decelerations[i])


@kernel
def _slip_of(v: FloatArray, w: FloatArray, radii: FloatArray, i: int) -> tuple[float, float]:
    return v[i, 0] - radii[i] * w[i, 1], v[i, 1] + radii[i] * w[i, 0]


@kernel
def _slowed(
    v: FloatArray, w: FloatArray, radii: FloatArray, rolling: BoolArray, i: int
) -> tuple[float, float]:
    """Return the vector that the cloth acts against: the velocity if rolling, else the slip."""
    if rolling[i]:
        return v[i, 0], v[i, 1]
    return _slip_of(v, w, radii, i)


@kernel(entry=True)
def accelerate(
    v: FloatArray,
    w: FloatArray,
    radii: FloatArray,
    rolling: BoolArray,
    rolls_by: FloatArray,
    slides_by: FloatArray,
    accelerations: FloatArray,
) -> None:
    """Write the accelerations of rolling and sliding balls, against the motion or the slip."""
    for i in range(len(radii)):
        u0, u1 = _slowed(v, w, radii, rolling, i)
        factor = _slowing(math.hypot(u0, u1), rolls_by[i] if rolling[i] else slides_by[i])
        accelerations[i, 0], accelerations[i, 1] = u0 * factor, u1 * factor


@kernel(entry=True)
def last(
    v: FloatArray,
    w: FloatArray,
    radii: FloatArray,
    rolling: BoolArray,
    rolls_by: FloatArray,
    slides_by: FloatArray,
    spins_by: FloatArray,
    durations: FloatArray,
) -> None:
    """Write how long balls roll or slide, and how long they spin about the vertical [s]."""
    for i in range(len(radii)):
        u0, u1 = _slowed(v, w, radii, rolling, i)
        by = rolls_by[i] if rolling[i] else 3.5 * slides_by[i]
        durations[i, 0] = _duration(math.hypot(u0, u1), by)
        durations[i, 1] = _duration(abs(w[i, 2]), spins_by[i])


@kernel(entry=True)
def move(dt: float, v: FloatArray, a: FloatArray, displacements: FloatArray) -> None:
    """Write the displacements in `dt`, and change the velocities."""
    for i in range(len(v)):
        for k in range(2):
            displacements[i, k] = (v[i, k] + 0.5 * a[i, k] * dt) * dt
            v[i, k] = v[i, k] + a[i, k] * dt


@kernel(entry=True)
def turn(
    dt: float,
    w: FloatArray,
    accelerations: FloatArray,
    radii: FloatArray,
    sliding: BoolArray,
    spins_by: FloatArray,
    ending: BoolArray,
) -> None:
    """Turn the sliding balls, and slow all vertical spins; spins that are `ending` become 0."""
    for i in range(len(radii)):
        if sliding[i]:
            w[i, 0] += 2.5 * dt * accelerations[i, 1] / radii[i]
            w[i, 1] -= 2.5 * dt * accelerations[i, 0] / radii[i]
        slower = math.copysign(abs(w[i, 2]) - spins_by[i] * dt, w[i, 2])
        w[i, 2] = 0.0 if ending[i] else slower


@kernel
def _later(
    dt: float,
    v: FloatArray,
    w: FloatArray,
    radius: float,
    rolls: bool,
    deceleration: float,
    i: int,
) -> tuple[float, float, float, float, float, float]:
    """Return displacement and velocity of ball i after `dt`, and its spin about x and y."""
    u0, u1 = v[i, 0], v[i, 1]
    if not rolls:
        u0, u1 = u0 - radius * w[i, 1], u1 + radius * w[i, 0]
    factor = _slowing(math.hypot(u0, u1), deceleration)
    a0, a1 = u0 * factor, u1 * factor
    d0, d1 = (v[i, 0] + 0.5 * a0 * dt) * dt, (v[i, 1] + 0.5 * a1 * dt) * dt
    w0, w1 = w[i, 0], w[i, 1]
    if not rolls:
        w0, w1 = w0 + 2.5 * dt * a1 / radius, w1 - 2.5 * dt * a0 / radius
    return d0, d1, v[i, 0] + a0 * dt, v[i, 1] + a1 * dt, w0, w1


@kernel
def _advance(
    dt: float,
    v: FloatArray,
    w: FloatArray,
    radii: FloatArray,
    rolling: BoolArray,
    rolls_by: FloatArray,
    slides_by: FloatArray,
    spins_by: FloatArray,
    turns: bool,
    displacements: FloatArray,
) -> bool:
    for i in range(len(radii)):
        u0, u1 = _slowed(v, w, radii, rolling, i)
        by = rolls_by[i] if rolling[i] else 3.5 * slides_by[i]
        speed, spins = math.hypot(u0, u1), _duration(abs(w[i, 2]), spins_by[i])
        if 0.0 < spins <= dt:
            return False
        if rolling[i] and v[i, 0] == 0.0 and v[i, 1] == 0.0:
            continue
        if _duration(speed, by) <= dt:
            return False
        deceleration = rolls_by[i] if rolling[i] else slides_by[i]
        _, _, v0, v1, w0, w1 = _later(dt, v, w, radii[i], rolling[i], deceleration, i)
        if not rolling[i]:
            v0, v1 = v0 - radii[i] * w1, v1 + radii[i] * w0
        if _duration(math.hypot(v0, v1), by) == 0.0:
            return False
    for i in range(len(radii)):
        deceleration = rolls_by[i] if rolling[i] else slides_by[i]
        d0, d1, v0, v1, w0, w1 = _later(dt, v, w, radii[i], rolling[i], deceleration, i)
        displacements[i, 0], displacements[i, 1] = 0.0 + d0, 0.0 + d1  # no -0
        v[i, 0], v[i, 1] = v0, v1
        if turns:
            w[i, 0], w[i, 1] = w0, w1
            slower = math.copysign(abs(w[i, 2]) - spins_by[i] * dt, w[i, 2])
            w[i, 2] = 0.0 if _duration(abs(w[i, 2]), spins_by[i]) == 0.0 else slower
    return True


@kernel(entry=True)
def advance_within_phases(
    dt: float,
    v: FloatArray,
    w: FloatArray,
    radii: FloatArray,
    rolling: BoolArray,
    rolls_by: FloatArray,
    slides_by: FloatArray,
    spins_by: FloatArray,
    turns: bool,
    displacements: FloatArray,
) -> bool:
    """Advance all balls by `dt`, unless a ball stops sliding, rolling or spinning by then.

    `turns`: whether spins change. The results have the bits of `accelerate`, `move` and `turn`.
    Returns False, and changes nothing, if a ball stops.
    """
    return _advance(dt, v, w, radii, rolling, rolls_by, slides_by, spins_by, turns, displacements)


@kernel
def _store(
    v: FloatArray, w: FloatArray, step: int, velocities: FloatArray, spins: FloatArray
) -> None:
    for i in range(len(v)):
        for k in range(2):
            velocities[step, i, k] = v[i, k]
        for k in range(3):
            spins[step, i, k] = w[i, k]


@kernel(entry=True)
def advance_steps(
    dt: float,
    v: FloatArray,
    w: FloatArray,
    radii: FloatArray,
    rolling: BoolArray,
    rolls_by: FloatArray,
    slides_by: FloatArray,
    spins_by: FloatArray,
    turns: bool,
    means: FloatArray,
    velocities: FloatArray,
    spins: FloatArray,
) -> int:
    """Advance all balls by steps of `dt`, until a ball stops sliding, rolling or spinning.

    `means`: (k, n, 2) [m/s], the mean velocities in each step.
    `velocities`, `spins`: (k + 1, n, 2) [m/s] and (k + 1, n, 3) [rad/s], v and w at the start of
        each step, and at the end of the last step.
    Returns the number of steps, at most k. The results have the bits of `advance_within_phases`
    followed by `ClosedFormCloth.keep`.
    """
    _store(v, w, 0, velocities, spins)
    for step in range(len(means)):
        if not _advance(
            dt, v, w, radii, rolling, rolls_by, slides_by, spins_by, turns, means[step]
        ):
            return step
        for i in range(len(radii)):
            for k in range(2):
                means[step, i, k] = means[step, i, k] / dt
                v[i, k] = v[i, k] + 0.0  # no -0, as in `ClosedFormCloth.keep`
        _store(v, w, step + 1, velocities, spins)
    return len(means)


@kernel(entry=True)
def all_rest(v: FloatArray, w: FloatArray, rolling: BoolArray, spins_by: FloatArray) -> bool:
    """Return whether no ball slides, rolls or spins; spin that doesn't decay isn't counted."""
    for i in range(len(rolling)):
        if not rolling[i] or v[i, 0] != 0.0 or v[i, 1] != 0.0:
            return False
        if w[i, 2] != 0.0 and spins_by[i] > 0.0:
            return False
    return True
