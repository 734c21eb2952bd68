"""Tests of turning slides in air: power series against an integration with 40 digits."""

from __future__ import annotations

import math
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from flint import arb
from shots import R, ball, scene_of

from ghostball.engine import simulate
from ghostball.engine.core import state as st
from ghostball.engine.core.state import Balls
from ghostball.engine.core.tolerances import EPS, SLIDE_ERROR
from ghostball.engine.motion import drag
from ghostball.model import EventKind
from ghostball.model.trajectory import polynomial
from ghostball.reference_adapters.certified.arithmetic import working_precision
from ghostball.reference_adapters.certified.integrated_slide import IntegratedSlide
from ghostball.reference_adapters.ghostball import GhostballEngine
from ghostball.validation.truth.collocation import BITS, Collocation

K, FRICTION = 0.0041, 0.2 * 9.81

Plane = tuple[float, float]

SLIDES = [((3.0, 0.4), (1.0, -2.0)), ((0.7, -1.9), (4.5, 0.3)), ((6.0, 0.0), (5.0, 3.0))]


@cache
def exact_slide(v: Plane, u: Plane) -> IntegratedSlide:
    with working_precision(BITS):
        both = [(arb(x), arb(y)) for x, y in (v, u)]
        return Collocation(14, arb((1, -2)))(*both, arb(FRICTION), arb(K))


def piece_of(v: Plane, u: Plane) -> tuple[Balls, float]:
    row = SimpleNamespace(vx=v[0], vy=v[1], slide_slowing=FRICTION, radius=R)
    powers = np.zeros((1, st.POWERS_COLUMNS))
    series = np.zeros((st.SERIES_ROWS, st.SERIES_TERMS))
    nothing = np.zeros(0)
    balls = Balls(
        [row], nothing, nothing, nothing, nothing, nothing,
        np.zeros(st.COUNTERS, dtype=np.int64), powers, series, None,
    )  # fmt: skip
    size, speed = math.hypot(*u), math.hypot(*v)
    return balls, float(drag._turn(powers, series, balls, 0, K, *u, size, speed))


def velocity_in(balls: Balls, s: float) -> list[float]:
    row, powers = balls.state[0], balls.powers[0, st.POWERS :]
    more = polynomial.tails(powers, int(balls.powers[0, st.COUNT]), s)[2:4]
    return [row.vx + row.ax * s + more[0], row.vy + row.ay * s + more[1]]


@pytest.mark.parametrize(("v", "u"), SLIDES)
def test_the_truncation_of_a_piece_is_within_its_limit(v, u):
    """The error is within the limit plus rounding, and the bounds on the jerk hold."""
    balls, lasts = piece_of(v, u)
    allowed = (SLIDE_ERROR + EPS) * (math.hypot(*v) + math.hypot(*u))
    slide = exact_slide(v, u)
    with working_precision(BITS):
        for share in np.linspace(0.05, 1.0, 20):
            exact = slide.velocity(arb(share * lasts))
            for found, true in zip(velocity_in(balls, share * lasts), exact, strict=True):
                assert abs(float(arb(found) - true)) <= allowed
    h = 1e-4 * lasts
    for s in np.linspace(h, lasts - h, 7):
        for axis in range(2):
            later, now, before = (velocity_in(balls, s + d)[axis] for d in (h, 0.0, -h))
            assert abs(later - 2.0 * now + before) / (h * h) <= balls.powers[0, axis] * 1.01


def test_a_piece_reflected_is_the_reflected_piece():
    (v, u), pieces = SLIDES[0], []
    for turned in (lambda x, y: (-x, y), lambda x, y: (y, x), lambda x, y: (-x, -y)):
        pieces = [piece_of(v, u), piece_of(turned(*v), turned(*u))]
        assert pieces[1][1] == pieces[0][1]
        at_end = [velocity_in(*piece) for piece in pieces]
        assert at_end[1] == list(turned(*at_end[0]))


def drawn(seed: int) -> tuple[Plane, Plane]:
    chance = np.random.default_rng(seed)
    speed, angle = chance.uniform(0.5, 8.0), chance.uniform(0.0, 2.0 * math.pi)
    spin = chance.normal(0.0, 0.7, 2) * speed / R
    velocity = (speed * math.cos(angle), speed * math.sin(angle))
    return velocity, (float(spin[0]), float(spin[1]))


@pytest.mark.parametrize("seed", range(4))
def test_a_slide_ends_where_its_integration_says_after_few_pieces(seed):
    """Fails if the error exceeds the resolution that the engine states for motion in air."""
    v, spin = drawn(seed)
    scene = scene_of(
        ball((0.0, 0.0), v, angular_velocity=(*spin, 0.0)),
        preset="pool", air_drag=K, gravity=9.81, sliding_friction=0.2,
    )  # fmt: skip
    result = simulate(scene, record="trajectory")
    assert result.events["kind"][0] == EventKind.SLIDE_TO_ROLL
    end = float(result.events["t"][0])
    state = result.sample([end])
    slide = exact_slide(v, (v[0] - R * spin[1], v[1] + R * spin[0]))
    speeds = math.hypot(*v) + R * math.hypot(*spin)
    allowed = 8.0 * SLIDE_ERROR * speeds
    with working_precision(BITS):
        assert abs(float(arb(end) - slide.duration)) * FRICTION <= allowed
        for found, exact in zip(state.velocities[0, 0, :2], slide.final_velocity, strict=True):
            assert abs(float(arb(float(found)) - exact)) <= allowed
        for found, exact in zip(state.positions[0, 0, :2], slide.end, strict=True):
            error = abs(float(arb(float(found)) - exact))
            assert error <= GhostballEngine().resolution(scene)
            assert error <= 1e-11
    assert np.sum(result.trajectory.segments[0][:, 0] < end) <= 24


@pytest.mark.parametrize(("speed", "place"), [(0.005, 1.0), (0.3, 80.0), (2.0, 1.0)])
def test_a_slide_far_from_the_origin_ends_within_the_resolution(speed: float, place: float) -> None:
    """Fails if the resolution leaves out the last piece, whose error is relative to the place."""
    v, spin = (0.8 * speed, 0.6 * speed), (0.9 * speed / R, 0.4 * speed / R)
    scene = scene_of(
        ball((place, 0.5 * place), v, angular_velocity=(*spin, 0.0)),
        preset="pool", air_drag=K, gravity=9.81, sliding_friction=0.2,
    )  # fmt: skip
    result = simulate(scene, record="trajectory")
    end = float(result.events["t"][0])
    state = result.sample([end])
    slide = exact_slide(v, (v[0] - R * spin[1], v[1] + R * spin[0]))
    with working_precision(BITS):
        moved = zip(state.positions[0, 0, :2], scene.positions[0, :2], slide.end, strict=True)
        off = [float(arb(float(a)) - arb(float(b)) - exact) for a, b, exact in moved]
        found = zip(state.velocities[0, 0, :2], slide.final_velocity, strict=True)
        faster = [float(arb(float(a)) - exact) for a, exact in found]
    rolls = speed / (9.81 * float(scene.rolling_frictions[0]))
    error = math.hypot(*off) + math.hypot(*faster) * rolls
    rounding = 4.0 * EPS * place
    assert error <= GhostballEngine().resolution(scene) + rounding
