"""How a small change of one ball's motion goes on between events, reaches one, and leaves it."""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    AX,
    AY,
    BX,
    BY,
    BZ,
    EPOCH,
    PHASE,
    RADIUS,
    RESTING,
    ROLL_SLOWING,
    SLIDE_SLOWING,
    SLIDING,
    SPIN_SLOWING,
    VX,
    VY,
    WX,
    WY,
    WZ,
    FloatArray,
    X,
    Y,
)
from ghostball.engine.sensitivity.state import (
    DVX,
    DVY,
    DWX,
    DWY,
    DWZ,
    DX,
    DY,
    PRE_AX,
    PRE_AY,
    PRE_BX,
    PRE_BY,
    PRE_BZ,
    PRE_VX,
    PRE_VY,
    PRE_WX,
    PRE_WY,
    PRE_WZ,
    ROW,
    TAU,
    Tangents,
)

_BITS = 0x7FFFFFFFFFFFFFFF
"""So many that a whole number of the compiler's has, without its sign."""


@kernel(inline=True)
def carry(run: Tangents, ball: int, k: int, t: float, row: FloatArray) -> None:
    """Put in `row`, (ROW,), the perturbation of a ball at the instant t, from that at its knot k.

    Contract: t lies between that knot and the next one. No allocation.

    Notes
    -----
    With P = 1 - d^ d^T across the direction d of the velocity, or of the slip u while the ball
    slides, and c its deceleration: da = -(c / |d|) P dd, dv += s da, dx += s dv + s^2 da / 2.
    """
    # Indices into slices are never below 0: the compiler sees that, and makes vectors.
    start = run.tangent[k * ROW : (k + 1) * ROW]
    for place in range(ROW):
        row[place] = start[place]
    s = t - run.knots[k, EPOCH]
    radius = run.state[ball, RADIUS]
    dx, dy = run.knots[k, VX], run.knots[k, VY]
    slides = run.knots[k, PHASE] == SLIDING
    slowing, lever = run.state[ball, ROLL_SLOWING], 0.0
    if slides:
        dx, dy = dx - radius * run.knots[k, WY], dy + radius * run.knots[k, WX]
        slowing, lever = run.state[ball, SLIDE_SLOWING], radius
    size2 = dx * dx + dy * dy
    over = -slowing / (size2 * math.sqrt(size2)) if size2 > 0.0 else 0.0
    _go_on(run.lanes, row, s, over * dy * dy, -over * dx * dy, over * dx * dx, lever, 1.0 / radius)
    rate = run.state[ball, SPIN_SLOWING]
    if run.laws.slides and rate > 0.0 and abs(run.knots[k, WZ]) <= s * rate:
        for lane in range(run.lanes):
            row[DWZ + lane] = 0.0


@kernel(inline=True)
def _go_on(
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
            vx, vy = row[DVX + lane], row[DVY + lane]
            wx, wy = row[DWX + lane], row[DWY + lane]
            ux, uy = vx - lever * wy, vy + lever * wx
            ax, ay = pxx * ux + pxy * uy, pxy * ux + pyy * uy
            row[DX + lane] += s * (vx + half * ax)
            row[DY + lane] += s * (vy + half * ay)
            row[DVX + lane] = vx + s * ax
            row[DVY + lane] = vy + s * ay
            row[DWX + lane] = wx + turn * ay
            row[DWY + lane] = wy - turn * ax
        return
    for lane in range(lanes):
        vx, vy = row[DVX + lane], row[DVY + lane]
        ax, ay = pxx * vx + pxy * vy, pxy * vx + pyy * vy
        row[DX + lane] += s * (vx + half * ax)
        row[DY + lane] += s * (vy + half * ay)
        vx, vy = vx + s * ax, vy + s * ay
        row[DVX + lane] = vx
        row[DVY + lane] = vy
        # Rolling, the ball turns as its velocity says.
        row[DWX + lane] = -over_radius * vy
        row[DWY + lane] = over_radius * vx


@kernel(inline=True)
def arrive(run: Tangents, ball: int, t: float, place: int) -> None:
    """Bring a ball, and its perturbation, to the event at t: row `place` of `motion`, of `work`."""
    k = run.at[ball]
    carry(run, ball, k, t, run.work[place * ROW : (place + 1) * ROW])
    s = t - run.knots[k, EPOCH]
    vx = run.knots[k, VX] + s * run.knots[k, AX]
    vy = run.knots[k, VY] + s * run.knots[k, AY]
    run.motion[place, PRE_VX] = vx
    run.motion[place, PRE_VY] = vy
    run.motion[place, PRE_AX] = run.knots[k, AX]
    run.motion[place, PRE_AY] = run.knots[k, AY]
    if run.knots[k, PHASE] == SLIDING:
        run.motion[place, PRE_BX] = run.knots[k, BX]
        run.motion[place, PRE_BY] = run.knots[k, BY]
        run.motion[place, PRE_WX] = run.knots[k, WX] + s * run.knots[k, BX]
        run.motion[place, PRE_WY] = run.knots[k, WY] + s * run.knots[k, BY]
    else:
        over = 1.0 / run.state[ball, RADIUS]
        run.motion[place, PRE_BX] = -run.knots[k, AY] * over
        run.motion[place, PRE_BY] = run.knots[k, AX] * over
        run.motion[place, PRE_WX] = -vy * over
        run.motion[place, PRE_WY] = vx * over
    spin, rate = run.knots[k, WZ], run.state[ball, SPIN_SLOWING]
    left = max(abs(spin) - s * rate, 0.0)
    run.motion[place, PRE_WZ] = left if spin > 0.0 else -left
    slowing = rate if left > 0.0 else 0.0
    run.motion[place, PRE_BZ] = (-slowing if spin > 0.0 else slowing) + run.knots[k, BZ]


@kernel(inline=True)
def shift_before(run: Tangents, place: int) -> None:
    """Bring a perturbation from the event's instant to where the event is for it: + f- dtau."""
    row, at = run.work[place * ROW :], TAU - place * ROW
    _shift(
        run.lanes,
        row,
        at,
        1.0,
        run.motion[place, PRE_VX],
        run.motion[place, PRE_VY],
        run.motion[place, PRE_AX],
        run.motion[place, PRE_AY],
    )
    if run.laws.slides:
        bx, by = run.motion[place, PRE_BX], run.motion[place, PRE_BY]
        _shift_turning(run.lanes, row, at, 1.0, bx, by, run.motion[place, PRE_BZ])


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
        row[DX + lane] += tau * vx
        row[DY + lane] += tau * vy
        row[DVX + lane] += tau * ax
        row[DVY + lane] += tau * ay


@kernel(inline=True)
def _shift_turning(
    lanes: int, row: FloatArray, at: int, sign: float, bx: float, by: float, bz: float
) -> None:
    """Add `sign` times dtau, which is at the place `at`, times the angular acceleration."""
    for lane in range(lanes):
        tau = sign * row[at + lane]
        row[DWX + lane] += tau * bx
        row[DWY + lane] += tau * by
        row[DWZ + lane] += tau * bz


@kernel(inline=True)
def depart(run: Tangents, ball: int, t: float, place: int, rows: int) -> None:
    """Take a perturbation back to the event's instant, - f+ dtau, and keep it at the next knot.

    `rows` balls are in the event.

    A ball that an impact leaves without slip rolls at once; a perturbed one slides first, for a
    time of the order of the perturbation, in which the cloth takes 2/7 of the slip. Likewise one
    that is left at rest stops again at once, where the cloth slows it.
    """
    k = run.at[ball] + 1
    row = run.work[place * ROW : (place + 1) * ROW]
    phase = run.knots[k, PHASE]
    if phase != SLIDING and run.laws.slides:
        _end_slip(run.lanes, row, run.state[ball, RADIUS])
    if phase == RESTING and run.state[ball, ROLL_SLOWING] > 0.0:
        for lane in range(run.lanes):
            row[DVX + lane] = 0.0
            row[DVY + lane] = 0.0
    vx, vy, ax, ay = run.knots[k, VX], run.knots[k, VY], run.knots[k, AX], run.knots[k, AY]
    at = TAU - place * ROW
    _shift(run.lanes, run.work[place * ROW :], at, -1.0, vx, vy, ax, ay)
    if run.laws.slides:
        bx = run.knots[k, BX] if phase == SLIDING else 0.0
        by = run.knots[k, BY] if phase == SLIDING else 0.0
        bz = run.state[ball, SPIN_SLOWING] if run.knots[k, WZ] != 0.0 else 0.0
        bz = -bz if run.knots[k, WZ] > 0.0 else bz
        _shift_turning(run.lanes, run.work[place * ROW :], at, -1.0, bx, by, bz)
    if run.rounding > 0.0:
        add_rounding(run, ball, k, t, place, rows)
    kept = run.tangent[k * ROW : (k + 1) * ROW]
    for one in range(ROW):
        kept[one] = row[one]
    run.at[ball] = k


@kernel(inline=True)
def _end_slip(lanes: int, row: FloatArray, radius: float) -> None:
    for lane in range(lanes):
        vx, vy = row[DVX + lane], row[DVY + lane]
        row[DVX + lane] = vx - (vx - radius * row[DWY + lane]) / 3.5
        row[DVY + lane] = vy - (vy + radius * row[DWX + lane]) / 3.5


@kernel(inline=True)
def add_rounding(run: Tangents, ball: int, k: int, t: float, place: int, rows: int) -> None:
    """Add to the perturbation in row `place` what rounding the ball's state at knot k might.

    Each number gets, with a random sign in each lane, the largest size that it, or what it was made
    of, has at the event, in which `rows` balls are. A number that is exactly 0 there stays so, and
    a ball's place along an axis changes only where it moves along it: what is symmetric about an
    axis is so to the last bit in our engine. A place is as uncertain as its gaps, which are
    compared with radii, and as what the ball covers while the clock, at t, rounds.

    The signs are a function of the ball's first place among all, and of how many knots it has had:
    no two roundings share them, or their errors would cancel or add up.
    """
    slides = run.knots[k, PHASE] == SLIDING
    radius = run.state[ball, RADIUS]
    speed_x, speed_y = abs(run.knots[k, VX]), abs(run.knots[k, VY])
    x = abs(run.knots[k, X]) + radius + t * speed_x
    y = abs(run.knots[k, Y]) + radius + t * speed_y
    turn_x, turn_y = (abs(run.knots[k, WX]), abs(run.knots[k, WY])) if slides else (0.0, 0.0)
    spin = abs(run.knots[k, WZ])
    for other in range(rows):
        speed_x = max(speed_x, abs(run.motion[other, PRE_VX]))
        speed_y = max(speed_y, abs(run.motion[other, PRE_VY]))
        turn_x = max(turn_x, abs(run.motion[other, PRE_WX]))
        turn_y = max(turn_y, abs(run.motion[other, PRE_WY]))
        spin = max(spin, abs(run.motion[other, PRE_WZ]))
    x = x if speed_x > 0.0 else 0.0
    y = y if speed_y > 0.0 else 0.0
    if run.knots[k, PHASE] == RESTING and run.state[ball, ROLL_SLOWING] > 0.0:
        speed_x, speed_y = 0.0, 0.0
    if not slides:
        turn_x, turn_y = 0.0, 0.0
    size = run.rounding
    signs = _mixed((int(run.signs) << 56) + (int(run.rank[ball]) << 32) + int(k - run.first[ball]))
    row = run.work[place * ROW : (place + 1) * ROW]
    _add_signed(run.lanes, row, signs, size * x, size * y, size * speed_x, size * speed_y)
    if run.laws.slides:
        _add_signed_turns(run.lanes, row, signs, size * turn_x, size * turn_y, size * spin)


@kernel(inline=True)
def _add_signed(
    lanes: int, row: FloatArray, signs: int, x: float, y: float, vx: float, vy: float
) -> None:
    """Add position and velocity, with these signs, to a perturbation."""
    for lane in range(lanes):
        row[DX + lane] += x * _sign(signs, DX + lane)
        row[DY + lane] += y * _sign(signs, DY + lane)
        row[DVX + lane] += vx * _sign(signs, DVX + lane)
        row[DVY + lane] += vy * _sign(signs, DVY + lane)


@kernel(inline=True)
def _add_signed_turns(
    lanes: int, row: FloatArray, signs: int, wx: float, wy: float, wz: float
) -> None:
    """Add an angular velocity, with these signs, to a perturbation."""
    for lane in range(lanes):
        row[DWX + lane] += wx * _sign(signs, DWX + lane)
        row[DWY + lane] += wy * _sign(signs, DWY + lane)
        row[DWZ + lane] += wz * _sign(signs, DWZ + lane)


@kernel(inline=True)
def _sign(signs: int, place: int) -> float:
    return 1.0 - 2.0 * ((signs >> place) & 1)


@kernel(inline=True)
def _mixed(number: int) -> int:
    """Return 63 bits that look random, a function of the number, which has at most so many.

    As Steele, Lea and Flood (2014), "Fast splittable pseudorandom number generators", in 63 bits.
    """
    bits = (number * 0x1E3779B97F4A7C15) & _BITS
    bits = ((bits ^ (bits >> 30)) * 0x3F58476D1CE4E5B9) & _BITS
    bits = ((bits ^ (bits >> 27)) * 0x14D049BB133111EB) & _BITS
    return bits ^ (bits >> 31)
