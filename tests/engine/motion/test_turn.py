"""Pieces of a slide that turns: against proofs, which know it to as many digits as one asks for."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from flint import arb
from shots import R, ball, scene_of

from ghostball.engine import simulate
from ghostball.engine.core import state as st
from ghostball.engine.core.state import Air, Balls
from ghostball.engine.core.tolerances import EPS
from ghostball.engine.motion import drag, turn
from ghostball.engine.motion.nodes import PARTS
from ghostball.model import EventKind
from ghostball.model.trajectory import polynomial
from ghostball.reference_adapters.certified.arithmetic import working_precision
from ghostball.reference_adapters.certified.slide import Slide

K, FRICTION = 0.0041, 0.2 * 9.81


def balls_of(v: tuple[float, float], friction: float = FRICTION) -> Balls:
    row = SimpleNamespace(vx=v[0], vy=v[1], slide_slowing=friction, radius=R)
    row.ax = row.ay = row.bx = row.by = math.nan
    higher = np.zeros((1, st.HIGHER + st.MOST_POWERS))
    air = Air(
        np.zeros((1, st.MOST_POWERS)),
        np.zeros((1, 0)),
        np.zeros((st.SERIES_ROWS, st.SERIES_TERMS)),
        np.zeros((st.NODES_ROWS, st.NODES_TERMS)),
    )
    nothing = np.zeros(0)
    return Balls(
        [row], nothing, nothing, nothing, nothing, nothing,
        np.zeros(st.COUNTERS, dtype=np.int64), higher, air, None,
    )  # fmt: skip


def piece_of(
    balls: Balls, u: tuple[float, float], k: float = K, begin: Any = turn.turn_piece
) -> float:
    row = balls.state[0]
    size, speed = math.hypot(*u), math.hypot(row.vx, row.vy)
    return float(begin(balls.higher, balls.air, balls, 0, k, *u, size, speed))


def velocity_in(balls: Balls, s: float) -> list[float]:
    row, powers = balls.state[0], balls.higher[0, st.HIGHER :]
    count = int(balls.higher[0, st.POWERS])
    more = polynomial.tails(powers, count, s)[2:4]
    return [row.vx + row.ax * s + more[0], row.vy + row.ay * s + more[1]]


SLIDES = [((3.0, 0.4), (1.0, -2.0)), ((0.7, -1.9), (4.5, 0.3)), ((6.0, 0.0), (5.0, 3.0))]


@pytest.mark.parametrize("part", range(1, len(PARTS)))
@pytest.mark.parametrize(("v", "u"), SLIDES)
def test_a_piece_that_is_too_long_errs_by_no_more_than_is_estimated(monkeypatch, v, u, part):
    """There the error is far above rounding; the estimate isn't far above it, either."""
    monkeypatch.setattr(turn, "_longest", lambda *_: part)
    monkeypatch.setattr(turn, "POWERS_LEAVE_OUT", 1.0)
    monkeypatch.setattr(turn, "_NODES_LEAVE_OUT", 1e-12)
    balls = balls_of(v)
    lasts = piece_of(balls, u)
    assert lasts > 0.0
    estimate = turn.left_out(balls.air.nodes, part, lasts)
    speeds = math.hypot(*v) + math.hypot(*u)
    with working_precision(106):
        slide = Slide(*(tuple(map(arb, both)) for both in (v, u)), arb(FRICTION), arb(K))
        worst = 0.0
        for share in np.linspace(0.05, 1.0, 39):
            exact = slide.velocity(arb(share * lasts))
            for found, true in zip(velocity_in(balls, share * lasts), exact, strict=True):
                worst = max(worst, abs(float(arb(found) - true)))
    assert worst <= estimate + 2e-13 * speeds
    if estimate > 1e-11 * speeds:
        assert worst >= estimate / 100.0


@pytest.mark.parametrize("begin", [turn.turn_piece, drag._turn], ids=["nodes", "power series"])
@pytest.mark.parametrize(("v", "u"), SLIDES)
def test_a_piece_as_it_is_chosen_errs_by_rounding(v, u, begin):
    balls = balls_of(v)
    lasts = piece_of(balls, u, begin=begin)
    speeds = math.hypot(*v) + math.hypot(*u)
    with working_precision(106):
        slide = Slide(*(tuple(map(arb, both)) for both in (v, u)), arb(FRICTION), arb(K))
        for share in np.linspace(0.05, 1.0, 20):
            exact = slide.velocity(arb(share * lasts))
            for found, true in zip(velocity_in(balls, share * lasts), exact, strict=True):
                assert abs(float(arb(found) - true)) <= EPS * speeds
    # How fast its acceleration changes is bounded by what it says: a' by differences.
    h = 1e-4 * lasts
    for s in np.linspace(h, lasts - h, 7):
        for axis in range(2):
            later, now, before = (velocity_in(balls, s + d)[axis] for d in (h, 0.0, -h))
            assert abs(later - 2.0 * now + before) / (h * h) <= balls.higher[0, axis] * 1.01


def test_a_piece_reflected_is_the_reflected_piece():
    for turned in (lambda x, y: (-x, y), lambda x, y: (y, x), lambda x, y: (-x, -y)):
        (v, u), pieces = SLIDES[0], []
        for a, b in ((v, u), (turned(*v), turned(*u))):
            balls = balls_of(a)
            lasts = piece_of(balls, b)
            pieces.append((lasts, velocity_in(balls, lasts)))
        assert pieces[1][0] == pieces[0][0]
        assert pieces[1][1] == list(turned(*pieces[0][1]))


@pytest.mark.parametrize(
    ("v", "k"), [((3.0, 0.4), 1.0), ((300.0, 0.4), K)], ids=["thick air", "fast"]
)
def test_where_the_air_does_as_much_as_the_cloth_no_piece_is_found(v, k):
    balls = balls_of(v)
    assert piece_of(balls, (1.0, -2.0), k) == 0.0
    assert math.isnan(balls.state[0].ax)
    assert balls.higher[0, st.POWERS] == 0.0


# --- whole slides


def drawn(seed: int) -> tuple[tuple[float, float], tuple[float, float]]:
    chance = np.random.default_rng(seed)
    speed, angle = chance.uniform(0.5, 8.0), chance.uniform(0.0, 2.0 * math.pi)
    spin = chance.normal(0.0, 0.7, 2) * speed / R
    velocity = (speed * math.cos(angle), speed * math.sin(angle))
    return velocity, (float(spin[0]), float(spin[1]))


@pytest.mark.parametrize("seed", range(12))
def test_a_slide_ends_where_its_proof_says_after_few_pieces(seed):
    v, spin = drawn(seed)
    scene = scene_of(
        ball((0.0, 0.0), v, angular_velocity=(*spin, 0.0)),
        preset="pool", air_drag=K, gravity=9.81, sliding_friction=0.2,
    )  # fmt: skip
    result = simulate(scene, record="trajectory")
    assert result.events["kind"][0] == EventKind.SLIDE_TO_ROLL
    end = float(result.events["t"][0])
    state = result.sample([end])
    with working_precision(133):  # 40 digits
        radius = arb(R)
        u = (arb(v[0]) - radius * spin[1], arb(v[1]) + radius * spin[0])
        slide = Slide((arb(v[0]), arb(v[1])), u, arb(FRICTION), arb(K))
        speeds = math.hypot(*v) + R * math.hypot(*spin)
        time = abs(float(arb(end) - slide.duration))
        assert time <= 2.0 * EPS * (end + speeds / (3.5 * FRICTION))
        place = state.positions[0, 0, :2]
        for found, exact in zip(place, slide.end, strict=True):
            assert abs(float(arb(float(found)) - exact)) <= 8.0 * EPS * max(1.0, speeds * end)
        for found, exact in zip(state.velocities[0, 0, :2], slide.final_velocity, strict=True):
            assert abs(float(arb(float(found)) - exact)) <= 2.0 * EPS * speeds
    assert np.sum(result.trajectory.segments[0][:, 0] < end) <= 16
