"""The time to the next contact agrees with dense sampling and closed forms."""

import math

import numpy as np
import pytest
from shots import R

from ghostball.model import Hole, Table
from ghostball.model.scene.obstacles import gap_to, is_inside
from ghostball.reference_adapters.stepping.contact_time import CONTACT_GAP, time_to_contact
from ghostball.reference_adapters.stepping.slowing import slow, stop

ROUNDING = 1e-14  # rounding of a gap between coordinates of about 1 m


def gaps_at(positions, radii, table):
    """Return all gaps of balls and cushions for positions (k, n, 2), by a simple method."""
    gaps = []
    n = len(radii)
    for i in range(n):
        for j in range(i + 1, n):
            distance = np.linalg.norm(positions[:, i] - positions[:, j], axis=1)
            gaps.append(distance - radii[i] - radii[j])
        x, y = positions[:, i, 0], positions[:, i, 1]
        sides = {"left": x, "right": table.length - x, "bottom": y, "top": table.width - y}
        gaps += [sides[name] - radii[i] for name in table.cushions]
    return np.array(gaps)


def rolling_accelerations(v, decelerations):
    accelerations = np.empty_like(v)
    slow(np.ascontiguousarray(v), decelerations, accelerations)
    return accelerations


def time_to_rest(v, decelerations):
    times = np.empty(len(v))
    stop(np.ascontiguousarray(v), decelerations, times)
    return times


def random_motion(rng):
    n = int(rng.integers(1, 6))
    radii = rng.uniform(0.5 * R, 2 * R, n)
    while True:
        x = rng.uniform(0.06, 0.94, (n, 2))
        distance = np.linalg.norm(x[:, None] - x[None], axis=2) - radii[:, None] - radii
        if np.all(distance[~np.eye(n, dtype=bool)] > 1e-6):
            break
    v = rng.normal(size=(n, 2)) * rng.choice([0.0, 1.0, 1.0], size=(n, 1))
    deceleration = float(rng.choice([0.0, 0.2, 2.0]))
    rests = time_to_rest(v, np.full(n, deceleration))
    horizon = min(0.5, *rests[rests > 0.0]) if np.any(rests > 0.0) else 0.5
    return x, v, rolling_accelerations(v, np.full(n, deceleration)), radii, horizon


def test_no_earlier_contact_and_an_end_on_the_gap():
    """Fails for a contact that is missed, late, early, or between wrong balls."""
    rng = np.random.default_rng(2009)
    table = Table(length=1.0, width=1.0, cushions=("left", "right", "top"))
    touching = 0
    for _ in range(300):
        x, v, a, radii, horizon = random_motion(rng)
        dt = time_to_contact(x, v, a, radii, table, horizon=horizon)
        times = np.linspace(0.0, min(dt, horizon), 1001)[:, None, None]
        gaps = gaps_at(x + v * times + 0.5 * a * times**2, radii, table)
        assert gaps.min() >= CONTACT_GAP - ROUNDING
        if dt < math.inf:
            touching += 1
            assert gaps[:, -1].min() == pytest.approx(CONTACT_GAP, abs=ROUNDING)
    assert 100 < touching < 280


@pytest.mark.parametrize("overlap", [1e-3, 1e-6, 1e-9, 1e-11, 1e-12])
def test_grazing(overlap):
    """Fails if a grazing contact is missed, or a miss becomes a contact."""
    reach = 2 * R + CONTACT_GAP
    for offset, touches in ((reach - overlap, True), (reach + overlap, False)):
        x = np.array([[0.0, 0.0], [0.5, offset]])
        v = np.array([[1.0, 0.0], [0.0, 0.0]])
        dt = time_to_contact(x, v, np.zeros((2, 2)), np.full(2, R), None, horizon=10.0)
        if touches:
            # Half of the chord, from (reach - offset)(reach + offset); short chords round more.
            chord = math.sqrt((reach - offset) * (reach + offset))
            assert dt == pytest.approx(0.5 - chord, abs=1e-15 / chord + 1e-14)
        else:
            assert dt == math.inf


@pytest.mark.parametrize(("gap", "closing"), [(1e-10, 2e-10), (0.0, 1e-10), (-5e-10, 1e-10)])
def test_balls_at_the_gap_close_to_an_overlap(gap, closing):
    """The second step of a contact lasts until the overlap, and is never 0."""
    x = np.array([[0.0, 0.0], [2 * R + gap, 0.0]])
    v = np.array([[0.5, 0.0], [0.0, 0.0]])
    dt = time_to_contact(x, v, np.zeros((2, 2)), np.full(2, R), None, horizon=1.0)
    assert dt == pytest.approx(closing / 0.5, rel=1e-6)


def test_separating_balls_count_when_they_come_back():
    """Balls that separate at 0.1 m/s, with 2 m/s^2 back, are in contact again after 0.1 s."""
    x = np.array([[0.0, 0.0], [2 * R, 0.0]])
    v = np.array([[0.0, 0.0], [0.1, 0.0]])
    a = np.array([[0.0, 0.0], [-2.0, 0.0]])
    dt = time_to_contact(x, v, a, np.full(2, R), None, horizon=1.0)
    assert dt == pytest.approx(0.1 + CONTACT_GAP / 0.1, rel=1e-9)
    assert time_to_contact(x, v, 0.0 * a, np.full(2, R), None, horizon=1.0) == math.inf


def test_only_named_cushions_and_each_at_its_own_distance():
    start, horizon = np.array([[0.4, 0.3]]), 10.0
    expected = {"left": 0.4, "right": 0.6, "bottom": 0.3, "top": 0.5}
    directions = {"left": (-1, 0), "right": (1, 0), "bottom": (0, -1), "top": (0, 1)}
    for name, distance in expected.items():
        v = np.array([directions[name]], dtype=float)
        arguments = (start, v, np.zeros((1, 2)), np.array([R]))
        table = Table(length=1.0, width=0.8, cushions=(name,))
        dt = time_to_contact(*arguments, table, horizon=horizon)
        assert dt == pytest.approx(distance - R - CONTACT_GAP, rel=1e-14)
        others = tuple(other for other in expected if other != name)
        without = Table(length=1.0, width=0.8, cushions=others)
        assert time_to_contact(*arguments, without, horizon=horizon) == math.inf
        assert time_to_contact(*arguments, None, horizon=horizon) == math.inf


def test_a_ball_that_turns_before_the_cushion_misses_it():
    """The turning point, v^2 / 2a from the start, is 1e-9 m before or beyond the cushion."""
    v, a = np.array([[1.0, 0.0]]), np.array([[-2.0, 0.0]])
    table = Table(length=1.0, width=1.0)
    for beyond, touches in ((1e-9, True), (-1e-9, False)):
        x = np.array([[1.0 - R - CONTACT_GAP - 0.25 + beyond, 0.5]])
        dt = time_to_contact(x, v, a, np.array([R]), table, horizon=0.9)
        assert (dt < math.inf) is touches


@pytest.mark.parametrize("speed", [5e-324, 1e-310, 1e-302])
def test_a_contact_beyond_all_time_is_none(speed):
    """A time above the range of doubles must not overflow, which would be an error in pytest."""
    x = np.array([[0.0, 0.0], [1.0, 0.0]])
    v = np.array([[speed, 0.0], [0.0, 0.0]])
    still = np.zeros_like(v)
    radii = np.array([R, R])
    table = Table(length=3.0, width=3.0)
    assert time_to_contact(x + 1.0, v, still, radii, table, horizon=math.inf) == math.inf
    # A tiny acceleration leads to such a time, too.
    v[0] = (-1.0, 0.0)
    returning = np.array([[5e-324, 0.0], [0.0, 0.0]])
    assert time_to_contact(x, v, returning, radii, None, horizon=math.inf) == math.inf


SHAPED = (
    Table.model_validate({"preset": "wpa-9ft", "length": 1.0, "width": 1.0}),
    Table.model_validate(
        {
            "vertices": [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.55, 1.0), (0.5, 0.6), (0.0, 1.0)],
            "posts": [{"centre": (0.3, 0.2), "radius": 0.04}],
        }
    ),
)


@pytest.mark.parametrize("table", SHAPED, ids=["pockets", "polygon and post"])
def test_parts_of_cushions_and_holes_are_met_at_the_gap_and_never_sooner(table):
    """Fails if a jaw, a facing, a corner, a post or a hole is missed, or has a wrong length."""
    rng = np.random.default_rng(354)
    met = np.zeros(len(table.obstacles), dtype=int)
    for _ in range(600):
        x = rng.uniform(0.05, 0.95, (1, 2))
        reaches = [0.0 if isinstance(one, Hole) else R for one in table.obstacles]
        gaps = [
            gap_to(one, *x.T)[0] - reach
            for one, reach in zip(table.obstacles, reaches, strict=True)
        ]
        if min(gaps) < 1e-3 or not is_inside(table.outline, *x.T)[0]:
            continue
        v = rng.normal(size=(1, 2))
        a = rolling_accelerations(v, np.array([float(rng.choice([0.0, 0.5]))]))
        horizon = min(1.0, *time_to_rest(v, np.array([0.5])))
        dt = time_to_contact(x, v, a, np.array([R]), table, horizon=horizon)
        times = np.linspace(0.0, min(dt, horizon), 2001)[:, np.newaxis]
        path = x + v * times + 0.5 * a * times**2
        away = np.array(
            [
                gap_to(one, *path.T) - reach
                for one, reach in zip(table.obstacles, reaches, strict=True)
            ]
        )
        assert away.min() >= CONTACT_GAP - ROUNDING
        if dt < math.inf:
            k = int(np.argmin(away[:, -1]))
            met[k] += 1
            assert away[k, -1] == pytest.approx(CONTACT_GAP, abs=ROUNDING)
    kinds = {type(one) for one, count in zip(table.obstacles, met, strict=True) if count}
    assert kinds == {type(one) for one in table.obstacles}


def test_what_touches_a_part_of_a_cushion_is_driven_in_by_a_gap():
    """The second step of a contact, as for balls; there is none if the ball separates."""
    table = SHAPED[1]
    x, still = np.array([[0.3, 0.24 + R + CONTACT_GAP]]), np.zeros((1, 2))
    v = np.array([[0.0, -1.0]])
    dt = time_to_contact(x, v, still, np.array([R]), table, horizon=1.0)
    assert dt == pytest.approx(2.0 * CONTACT_GAP, rel=1e-5)
    assert time_to_contact(x, -v, still, np.array([R]), table, horizon=0.1) == math.inf
