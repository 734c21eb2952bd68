"""One piece of a slide in air: whatever is wrong with it shows in its bound."""

import math

import pytest
from flint import arb, arb_poly

from ghostball.reference_adapters.certified.arithmetic import (
    working_precision,
)
from ghostball.reference_adapters.certified.slide_piece import (
    State,
    _failure,
    _Found,
    _series,
)

K = 0.0041


A = 0.2 * 9.81


def test_a_piece_that_is_wrong_is_found_out() -> None:
    """A wrong coefficient of any series shows in the bound: the proof is not in how it was made."""
    with working_precision(106):
        state = State.of((arb(2), arb("0.25")), (arb("1.5"), arb("-1.75")))
        friction, drag, noise, h = arb(A), arb(K), arb((1, -106)), arb((1, -5))
        *series, found = _series(state, h, friction, drag, noise)

        def failure(series, found) -> float:
            v, q = map(arb_poly, series[:2]), map(arb_poly, series[2:])
            v, q = tuple(v), tuple(q)
            u = (v[0] + q[0], v[1] + q[1])
            return float(_failure(v, q, u, found, h, friction, drag)[0])

        assert failure(series, found) < 1e-28
        for k in range(4):
            for power in (1, 2, 5):
                wrong = [list(part) for part in series]
                wrong[k][power] += arb("1e-12")
                assert failure(wrong, found) > 0.9e-12 * power * 2.0 ** (-5 * (power - 1)) * 0.6
        for k in range(4):
            parts = [list(part) for part in found]
            parts[k][1] += arb("1e-12")
            assert failure(series, type(found)(*parts)) > 1e-16


@pytest.mark.parametrize("degrees", [10, 60, 89])
def test_a_piece_whose_slip_points_elsewhere_fails_by_no_more_than_is_said(degrees: int) -> None:
    """Broken by half the bound of how far the slip's direction is off, which is none any more.

    The curve follows the equations of a slip along x, and its own slip lies at an angle to it.
    """
    angle, friction, h = math.radians(degrees), 2.0, 2.0**-60
    slip = (math.cos(angle), math.sin(angle))
    v = arb_poly([slip[0], -friction]), arb_poly([slip[1]])
    q = arb_poly([0.0, -2.5 * friction]), arb_poly([0.0])
    found = _Found([arb(slip[0])], [arb(1)], [arb(0)], [])
    u = (v[0] + q[0], v[1] + q[1])
    said, _ = _failure(v, q, u, found, arb(h), arb(friction), arb(0))
    # In the metric of the energy, |v|^2 + (2/5) |q|^2.
    made = friction * 2.0 * math.sin(0.5 * angle) * math.sqrt(1.0 + 0.4 * 2.5**2)
    assert made <= float(said) < 3.0 * made


@pytest.mark.parametrize("factor", [0.1, 0.9, 1.1, 10.0])
def test_a_piece_whose_speed_is_another_fails_by_no_more_than_is_said(factor: float) -> None:
    """Broken by half the bound of how far the speed is off that the air slows."""
    friction, drag, speed, h = 2.0, 0.5, 3.0, 2.0**-60
    taken = factor * speed
    v = arb_poly([speed, -friction - drag * taken * speed]), arb_poly([0.0])
    q = arb_poly([1.0 - speed, -2.5 * friction]), arb_poly([0.0])
    found = _Found([arb(1)], [arb(1)], [arb(0)], [arb(taken)])
    u = (v[0] + q[0], v[1] + q[1])
    said, _ = _failure(v, q, u, found, arb(h), arb(friction), arb(drag))
    assert drag * speed * abs(taken - speed) <= float(said)
