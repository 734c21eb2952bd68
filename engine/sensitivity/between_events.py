"""How a small change of one ball's motion continues between events, reaches one, and leaves it."""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import FloatArray
from ghostball.engine.sensitivity import state as ts
from ghostball.engine.sensitivity.state import Tangents

_BITS = 0x7FFFFFFFFFFFFFFF
"""So many that a whole number of the compiler's has, without its sign."""


@kernel(inline=True)
def carry(run: Tangents, ball: int, k: int, t: float, row: FloatArray) -> None:
    """Put in `row`, (ROW_LENGTH,), the perturbation of a ball at the instant t in its segment k.

    Contract: t lies between the start of that segment and of the next one. No allocation.

    With P = 1 - d^ d^T across the direction d of the velocity, or of the slip u while the ball
    slides, and c its deceleration: da = -(c / |d|) P dd, dv += s da, dx += s dv + s^2 da / 2.
    """
    # Indices into slices are never below 0: the compiler sees that, and makes vectors.
    start = run.tangent[k * ts.ROW_LENGTH : (k + 1) * ts.ROW_LENGTH]
    for index in range(ts.ROW_LENGTH):
        row[index] = start[index]
    s = t - run.segments[k, st.EPOCH]
    radius = run.state[ball, st.RADIUS]
    dx, dy = run.segments[k, st.VX], run.segments[k, st.VY]
    slides = run.segments[k, st.PHASE] == st.SLIDING
    slowing, lever = run.state[ball, st.ROLL_SLOWING], 0.0
    if slides:
        dx, dy = dx - radius * run.segments[k, st.WY], dy + radius * run.segments[k, st.WX]
        slowing, lever = run.state[ball, st.SLIDE_SLOWING], radius
    size2 = dx * dx + dy * dy
    over = -slowing / (size2 * math.sqrt(size2)) if size2 > 0.0 else 0.0
    _continue(
        run.lanes, row, s, over * dy * dy, -over * dx * dy, over * dx * dx, lever, 1.0 / radius
    )
    rate = run.state[ball, st.SPIN_SLOWING]
    if run.laws.slides and rate > 0.0 and abs(run.segments[k, st.WZ]) <= s * rate:
        for lane in range(run.lanes):
            row[ts.DWZ + lane] = 0.0


@kernel(inline=True)
def _continue(
    lanes: int,
    row: FloatArray,
    s: float,
    pxx: float,
    pxy: float,
    pyy: float,
    lever: float,
    over_radius: float,
) -> None:
    """Move a perturbation on by s [s]; `lever` is the radius of a ball that slides, else 0 [m]."""
    half = 0.5 * s
    if lever > 0.0:
        turn = 2.5 * s * over_radius
        for lane in range(lanes):
            vx, vy = row[ts.DVX + lane], row[ts.DVY + lane]
            wx, wy = row[ts.DWX + lane], row[ts.DWY + lane]
            ux, uy = vx - lever * wy, vy + lever * wx
            ax, ay = pxx * ux + pxy * uy, pxy * ux + pyy * uy
            row[ts.DX + lane] += s * (vx + half * ax)
            row[ts.DY + lane] += s * (vy + half * ay)
            row[ts.DVX + lane] = vx + s * ax
            row[ts.DVY + lane] = vy + s * ay
            row[ts.DWX + lane] = wx + turn * ay
            row[ts.DWY + lane] = wy - turn * ax
        return
    for lane in range(lanes):
        vx, vy = row[ts.DVX + lane], row[ts.DVY + lane]
        ax, ay = pxx * vx + pxy * vy, pxy * vx + pyy * vy
        row[ts.DX + lane] += s * (vx + half * ax)
        row[ts.DY + lane] += s * (vy + half * ay)
        vx, vy = vx + s * ax, vy + s * ay
        row[ts.DVX + lane] = vx
        row[ts.DVY + lane] = vy
        # Rolling, the ball turns as its velocity says.
        row[ts.DWX + lane] = -over_radius * vy
        row[ts.DWY + lane] = over_radius * vx


@kernel(inline=True)
def arrive(run: Tangents, ball: int, t: float, index: int) -> None:
    """Bring a ball, and its perturbation, to the event at t: row `index` of `motion`, of `work`."""
    k = run.at[ball]
    carry(run, ball, k, t, run.work[index * ts.ROW_LENGTH : (index + 1) * ts.ROW_LENGTH])
    s = t - run.segments[k, st.EPOCH]
    vx = run.segments[k, st.VX] + s * run.segments[k, st.AX]
    vy = run.segments[k, st.VY] + s * run.segments[k, st.AY]
    run.motion[index, ts.PRE_VX] = vx
    run.motion[index, ts.PRE_VY] = vy
    run.motion[index, ts.PRE_AX] = run.segments[k, st.AX]
    run.motion[index, ts.PRE_AY] = run.segments[k, st.AY]
    if run.segments[k, st.PHASE] == st.SLIDING:
        run.motion[index, ts.PRE_BX] = run.segments[k, st.BX]
        run.motion[index, ts.PRE_BY] = run.segments[k, st.BY]
        run.motion[index, ts.PRE_WX] = run.segments[k, st.WX] + s * run.segments[k, st.BX]
        run.motion[index, ts.PRE_WY] = run.segments[k, st.WY] + s * run.segments[k, st.BY]
    else:
        over = 1.0 / run.state[ball, st.RADIUS]
        run.motion[index, ts.PRE_BX] = -run.segments[k, st.AY] * over
        run.motion[index, ts.PRE_BY] = run.segments[k, st.AX] * over
        run.motion[index, ts.PRE_WX] = -vy * over
        run.motion[index, ts.PRE_WY] = vx * over
    spin, rate = run.segments[k, st.WZ], run.state[ball, st.SPIN_SLOWING]
    left = max(abs(spin) - s * rate, 0.0)
    run.motion[index, ts.PRE_WZ] = left if spin > 0.0 else -left
    slowing = rate if left > 0.0 else 0.0
    run.motion[index, ts.PRE_BZ] = (-slowing if spin > 0.0 else slowing) + run.segments[k, st.BZ]


@kernel(inline=True)
def shift_before(run: Tangents, index: int) -> None:
    """Bring a perturbation from the event's instant to where the event is for it: + f- dtau."""
    row, at = run.work[index * ts.ROW_LENGTH :], ts.TAU - index * ts.ROW_LENGTH
    _shift(
        run.lanes,
        row,
        at,
        1.0,
        run.motion[index, ts.PRE_VX],
        run.motion[index, ts.PRE_VY],
        run.motion[index, ts.PRE_AX],
        run.motion[index, ts.PRE_AY],
    )
    if run.laws.slides:
        bx, by = run.motion[index, ts.PRE_BX], run.motion[index, ts.PRE_BY]
        _shift_turning(run.lanes, row, at, 1.0, bx, by, run.motion[index, ts.PRE_BZ])


@kernel(inline=True)
def _shift(
    lanes: int,
    row: FloatArray,
    at: int,
    sign: float,
    vx: float,
    vy: float,
    ax: float,
    ay: float,
) -> None:
    """Add `sign` times dtau, which is at the place `at`, times velocity and acceleration."""
    for lane in range(lanes):
        tau = sign * row[at + lane]
        row[ts.DX + lane] += tau * vx
        row[ts.DY + lane] += tau * vy
        row[ts.DVX + lane] += tau * ax
        row[ts.DVY + lane] += tau * ay


@kernel(inline=True)
def _shift_turning(
    lanes: int, row: FloatArray, at: int, sign: float, bx: float, by: float, bz: float
) -> None:
    """Add `sign` times dtau, which is at the place `at`, times the angular acceleration."""
    for lane in range(lanes):
        tau = sign * row[at + lane]
        row[ts.DWX + lane] += tau * bx
        row[ts.DWY + lane] += tau * by
        row[ts.DWZ + lane] += tau * bz


@kernel(inline=True)
def depart(run: Tangents, ball: int, t: float, index: int, balls: int) -> None:
    """Take a perturbation back to the event's instant, - f+ dtau; the next segment starts with it.

    `balls` balls are in the event.

    A ball that an impact leaves without slip rolls at once; a perturbed one slides first, for a
    time of the order of the perturbation, in which the cloth takes 2/7 of the slip. Likewise one
    that is left at rest stops again at once, where the cloth slows it.
    """
    k = run.at[ball] + 1
    row = run.work[index * ts.ROW_LENGTH : (index + 1) * ts.ROW_LENGTH]
    phase = run.segments[k, st.PHASE]
    if phase != st.SLIDING and run.laws.slides:
        _end_slip(run.lanes, row, run.state[ball, st.RADIUS])
    if phase == st.RESTING and run.state[ball, st.ROLL_SLOWING] > 0.0:
        for lane in range(run.lanes):
            row[ts.DVX + lane] = 0.0
            row[ts.DVY + lane] = 0.0
    vx, vy, ax, ay = (
        run.segments[k, st.VX],
        run.segments[k, st.VY],
        run.segments[k, st.AX],
        run.segments[k, st.AY],
    )
    at = ts.TAU - index * ts.ROW_LENGTH
    _shift(run.lanes, run.work[index * ts.ROW_LENGTH :], at, -1.0, vx, vy, ax, ay)
    if run.laws.slides:
        bx = run.segments[k, st.BX] if phase == st.SLIDING else 0.0
        by = run.segments[k, st.BY] if phase == st.SLIDING else 0.0
        bz = run.state[ball, st.SPIN_SLOWING] if run.segments[k, st.WZ] != 0.0 else 0.0
        bz = -bz if run.segments[k, st.WZ] > 0.0 else bz
        _shift_turning(run.lanes, run.work[index * ts.ROW_LENGTH :], at, -1.0, bx, by, bz)
    if run.rounding > 0.0:
        add_rounding(run, ball, k, t, index, balls)
    kept = run.tangent[k * ts.ROW_LENGTH : (k + 1) * ts.ROW_LENGTH]
    for one in range(ts.ROW_LENGTH):
        kept[one] = row[one]
    run.at[ball] = k


@kernel(inline=True)
def _end_slip(lanes: int, row: FloatArray, radius: float) -> None:
    for lane in range(lanes):
        vx, vy = row[ts.DVX + lane], row[ts.DVY + lane]
        row[ts.DVX + lane] = vx - (vx - radius * row[ts.DWY + lane]) / 3.5
        row[ts.DVY + lane] = vy - (vy + radius * row[ts.DWX + lane]) / 3.5


@kernel(inline=True)
def add_rounding(run: Tangents, ball: int, k: int, t: float, index: int, balls: int) -> None:
    """Add to the perturbation in row `index` what rounding the state at segment k's start might.

    Each number gets, with a random sign in each lane, the largest size that it, or what it was made
    of, has at the event, in which `balls` balls are. A number that is exactly 0 there stays so, and
    a ball's place along an axis changes only where it moves along it: what is symmetric about an
    axis is so to the last bit in our engine. A place is as uncertain as its gaps, which are
    compared with radii, and as what the ball covers while the clock, at t, rounds.

    The signs are a function of the ball's first place among all, and of how many segments it has
    had: no two roundings share them, or their errors would cancel or add up.
    """
    slides = run.segments[k, st.PHASE] == st.SLIDING
    radius = run.state[ball, st.RADIUS]
    speed_x, speed_y = abs(run.segments[k, st.VX]), abs(run.segments[k, st.VY])
    x = abs(run.segments[k, st.X]) + radius + t * speed_x
    y = abs(run.segments[k, st.Y]) + radius + t * speed_y
    turn_x, turn_y = (
        (abs(run.segments[k, st.WX]), abs(run.segments[k, st.WY])) if slides else (0.0, 0.0)
    )
    spin = abs(run.segments[k, st.WZ])
    for other in range(balls):
        speed_x = max(speed_x, abs(run.motion[other, ts.PRE_VX]))
        speed_y = max(speed_y, abs(run.motion[other, ts.PRE_VY]))
        turn_x = max(turn_x, abs(run.motion[other, ts.PRE_WX]))
        turn_y = max(turn_y, abs(run.motion[other, ts.PRE_WY]))
        spin = max(spin, abs(run.motion[other, ts.PRE_WZ]))
    x = x if speed_x > 0.0 else 0.0
    y = y if speed_y > 0.0 else 0.0
    rests = run.segments[k, st.PHASE] == st.RESTING and run.state[ball, st.ROLL_SLOWING] > 0.0
    gone = run.segments[k, st.PHASE] == st.GONE
    if rests or gone:
        speed_x, speed_y = 0.0, 0.0
    spin = 0.0 if gone else spin
    if not slides:
        turn_x, turn_y = 0.0, 0.0
    size = run.rounding
    signs = _mixed((int(run.signs) << 56) + (int(run.rank[ball]) << 32) + int(k - run.first[ball]))
    row = run.work[index * ts.ROW_LENGTH : (index + 1) * ts.ROW_LENGTH]
    _add_signed(run.lanes, row, signs, size * x, size * y, size * speed_x, size * speed_y)
    if run.laws.slides:
        _add_signed_turns(run.lanes, row, signs, size * turn_x, size * turn_y, size * spin)


@kernel(inline=True)
def _add_signed(
    lanes: int, row: FloatArray, signs: int, x: float, y: float, vx: float, vy: float
) -> None:
    """Add position and velocity, with these signs, to a perturbation."""
    for lane in range(lanes):
        row[ts.DX + lane] += x * _sign(signs, ts.DX + lane)
        row[ts.DY + lane] += y * _sign(signs, ts.DY + lane)
        row[ts.DVX + lane] += vx * _sign(signs, ts.DVX + lane)
        row[ts.DVY + lane] += vy * _sign(signs, ts.DVY + lane)


@kernel(inline=True)
def _add_signed_turns(
    lanes: int, row: FloatArray, signs: int, wx: float, wy: float, wz: float
) -> None:
    """Add an angular velocity, with these signs, to a perturbation."""
    for lane in range(lanes):
        row[ts.DWX + lane] += wx * _sign(signs, ts.DWX + lane)
        row[ts.DWY + lane] += wy * _sign(signs, ts.DWY + lane)
        row[ts.DWZ + lane] += wz * _sign(signs, ts.DWZ + lane)


@kernel(inline=True)
def _sign(signs: int, index: int) -> float:
    return 1.0 - 2.0 * ((signs >> index) & 1)


@kernel(inline=True)
def _mixed(number: int) -> int:
    """Return 63 bits that look random, a function of the number, which has at most so many.

    As Steele, Lea and Flood (2014), "Fast splittable pseudorandom number generators", in 63 bits.
    """
    bits = (number * 0x1E3779B97F4A7C15) & _BITS
    bits = ((bits ^ (bits >> 30)) * 0x3F58476D1CE4E5B9) & _BITS
    bits = ((bits ^ (bits >> 27)) * 0x14D049BB133111EB) & _BITS
    return bits ^ (bits >> 31)
