"""The effect of an impact in multiprecision: ball against ball, and ball against cushion.

The frame is n, t, z: n the normal of the contact, t = z x n along it, z up.
"""

from __future__ import annotations

from mpmath import mp, mpf

from ghostball.validation.truth.closed_forms._motion import (
    BallState,
    along,
    dot,
    length_of,
    negligible,
    rolling_spin,
    scaled,
    slip_of,
)
from ghostball.validation.truth.closed_forms._setup import Setup, Spin, Vector

NORMALS = {"left": (-1, 0), "right": (1, 0), "bottom": (0, -1), "top": (0, 1)}
"""Unit vectors into the cushions."""


def alciatore_friction(speed: mpf) -> mpf:
    """Return the friction of two balls with surfaces that slip at `speed` [m/s] (TP A.14).

    Marlow's measurements, fitted by Alciatore; the coefficients are doubles, as in the engines.
    """
    return mp.mpf(9.951e-3) + mp.mpf(0.108) * mp.exp(-mp.mpf(1.088) * speed)


def ball_impact(
    setup: Setup, a: int, b: int, state_a: BallState, state_b: BallState
) -> tuple[BallState, BallState]:
    """Return the states of two touching balls after their impact.

    Along n the impulse is (1 + e) m_r (v_a - v_b).n. Across it, friction acts against the slip U of
    the surfaces: mu times this impulse, but at most (2/7) m_r U, which ends the slip (Wallace and
    Schroeder 1988; Alciatore TP A.14). The vertical part changes the spins; the cloth absorbs its
    momentum.
    """
    between = along(state_b.position, mp.mpf(-1), state_a.position)
    normal = scaled(1 / length_of(between), between)
    closing = dot(state_a.velocity, normal) - dot(state_b.velocity, normal)
    # push, rub and lift are impulses over the reduced mass [m/s]
    push = (1 + setup.ball_restitution) * closing
    rub, lift = _rubbing(setup, normal, push, (a, state_a), (b, state_b))
    mass_a, mass_b = setup.masses[a], setup.masses[b]
    reduced = mass_a * mass_b / (mass_a + mass_b)
    after = []
    for ball, state, sign in ((a, state_a, -1), (b, state_b, 1)):
        share = reduced / setup.masses[ball]
        velocity = along(state.velocity, sign * share * push, normal)
        velocity = along(velocity, sign * share * rub, _across(normal))
        if not setup.slides:
            after.append(state._replace(velocity=velocity))
            continue
        turn = 5 * share / (2 * setup.radii[ball])
        tx, ty = scaled(turn * lift, _across(normal))
        wx, wy, wz = rolling_spin(state, setup.radii[ball])
        spin = (wx + tx, wy + ty, wz - turn * rub)
        after.append(_settled(BallState(state.position, velocity, spin, False), setup.radii[ball]))
    return after[0], after[1]


def cushion_impact(setup: Setup, ball: int, cushion: str, state: BallState) -> BallState:
    """Return the state of a ball at a cushion after the impact, by the scene's law."""
    nx, ny = NORMALS[cushion]
    normal = (mp.mpf(nx), mp.mpf(ny))
    across = _across(normal)
    radius = setup.radii[ball]
    spin = rolling_spin(state, radius)
    vn, vt = dot(state.velocity, normal), dot(state.velocity, across)
    e = setup.cushion_restitution / (1 + setup.cushion_restitution_loss * mp.sqrt(vn))
    if setup.cushion in ("mirror", "restitution"):
        vn, vt = -e * vn, setup.cushion_tangential_restitution * vt
    else:
        turning = (dot(spin[:2], normal), dot(spin[:2], across), spin[2])
        vn, vt, (wn, wt, wz) = _han(setup, radius, e, (vn, vt), turning)
        horizontal = along(scaled(wn, normal), wt, across)
        spin = (horizontal[0], horizontal[1], wz)
    velocity = along(scaled(vn, normal), vt, across)
    if not setup.slides:
        return state._replace(velocity=velocity)
    return _settled(BallState(state.position, velocity, spin, False), radius)


def _rubbing(
    setup: Setup, normal: Vector, push: mpf, a: tuple[int, BallState], b: tuple[int, BallState]
) -> tuple[mpf, mpf]:
    """Return the impulse of friction on b along t and up, over the reduced mass [m/s]."""
    across = _across(normal)
    slip, rise = mp.mpf(0), mp.mpf(0)
    for (ball, state), sign in ((a, 1), (b, -1)):
        radius = setup.radii[ball]
        spin = rolling_spin(state, radius)
        slip += sign * dot(state.velocity, across) + radius * spin[2]
        rise -= radius * dot(spin[:2], across)
    speed = mp.hypot(slip, rise)
    friction = setup.ball_friction
    if friction is None:
        friction = alciatore_friction(speed)
    if not setup.slides or negligible(speed):
        return mp.mpf(0), mp.mpf(0)
    size = min(friction * push, 2 * speed / 7)
    return size * slip / speed, size * rise / speed


def _han(
    setup: Setup, radius: mpf, e: mpf, velocity: Vector, turning: Spin
) -> tuple[mpf, mpf, Spin]:
    """Return velocity and angular velocity in the frame n, t, z after an impact on Han's cushion.

    Han 2005, J. Mech. Sci. Tech. 19(4) 976, eqs 12-21 with corrected misprints. The nose touches
    the ball at the angle theta above its centre. "frictional" is the same with theta = 0,
    "stronge2000" with another impulse along the slip. Impulses are over the ball's mass [m/s];
    I = (2/5) m R^2.
    """
    (vn, vt), (wn, wt, wz) = velocity, turning
    sin = mp.mpf(0) if setup.cushion == "frictional" else setup.cushion_height / radius - 1
    cos = mp.sqrt(1 - sin**2)
    sx = vn * sin + radius * wt
    sy = -vt - radius * wz * cos + radius * wn * sin
    pz = (1 + e) * vn * cos
    slip = mp.hypot(sx, sy)
    if setup.cushion == "stronge2000":
        part = sprung_part(setup, slip / (vn * cos), e)
        px, py = part * sx, part * sy
    elif 2 * slip / 7 <= setup.cushion_friction * pz:
        px, py = 2 * sx / 7, 2 * sy / 7
    else:
        px, py = (setup.cushion_friction * pz * part / slip for part in (sx, sy))
    impulse_n, impulse_up = -px * sin - pz * cos, px * cos - pz * sin
    turn = 5 / (2 * radius)
    return (
        vn + impulse_n,
        vt + py,
        (
            wn - turn * py * sin,
            wt + turn * (impulse_n * sin - impulse_up * cos),
            wz + turn * py * cos,
        ),
    )


def sprung_part(setup: Setup, slip: mpf, e: mpf) -> mpf:
    """Return the impulse along the slip divided by the slip, by Stronge's two springs.

    `slip`: over the closing speed.

    Stronge 2000, Impact Mechanics, chapter 5. Time is in units of 1 / the frequency of the normal
    spring, speeds in units of the closing speed. The second spring has the deflection u. While its
    end slips, u is mu k sin(phase), where k = 3.5 / ratio^2; while its end sticks, u oscillates
    with the frequency `ratio`. Sticking begins when the speed of the ball's surface equals that of
    the end, and ends when the spring pulls more strongly than friction.
    """
    mu, ratio, quarter = setup.cushion_friction, setup.cushion_frequency_ratio, mp.pi / 2
    if negligible(slip) or mu == 0:
        return mp.mpf(0)
    k = mp.mpf("3.5") / ratio**2
    end = quarter * (1 + e)

    def phase(t: mpf) -> mpf:
        return t if t <= quarter else quarter + (t - quarter) / e

    def impulse(t: mpf) -> mpf:
        return 1 - mp.cos(phase(t)) * (1 if t <= quarter else e)

    begin, u, speed = mp.mpf(0), mp.mpf(0), slip
    if slip > mu * k:
        cos = (mp.mpf("3.5") - slip / mu) / (mp.mpf("3.5") - k)
        begin = mp.acos(cos) if abs(cos) <= 1 else end
        if slip > mp.mpf("3.5") * mu:
            held = mp.mpf("3.5") * e - (k / e if e > 0 else mp.inf)
            cos = (mp.mpf("3.5") - slip / mu) / held if held > 0 else mp.mpf(-2)
            begin = quarter + e * (mp.acos(cos) - quarter) if cos > -1 else end
        if begin >= end:
            return mu * (1 + e) / slip
        u, speed = mu * k * mp.sin(phase(begin)), slip - mp.mpf("3.5") * mu * impulse(begin)

    def deflection(t: mpf) -> mpf:
        turned = ratio * (t - begin)
        return u * mp.cos(turned) + speed / ratio * mp.sin(turned)

    def excess(t: mpf) -> mpf:
        return abs(deflection(t)) - mu * k * mp.sin(phase(t))

    low, first = max(begin, quarter), max(begin, quarter)
    for trial in range(1, 65):
        high = first + (end - first) * trial / 64
        if trial == 64 or excess(high) > 0:
            break
        low = high
    while high - low > end * mp.mpf(10) ** (4 - mp.dps):
        middle = (low + high) / 2
        low, high = (low, middle) if excess(middle) > 0 else (middle, high)
    turned = ratio * (high - begin)
    left = speed * mp.cos(turned) - u * ratio * mp.sin(turned)
    left -= mp.sign(deflection(high)) * mp.mpf("3.5") * mu * (1 + e - impulse(high))
    return (slip - left) / (mp.mpf("3.5") * slip)


def _across(normal: Vector) -> Vector:
    """Return t = z x n."""
    return (-normal[1], normal[0])


def _settled(state: BallState, radius: mpf) -> BallState:
    """Return a state with its field `rolls` set."""
    return state._replace(rolls=negligible(length_of(slip_of(state, radius))))
