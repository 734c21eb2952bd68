"""The tables of pieces found at nodes: what they do is known in closed form."""

from __future__ import annotations

import hashlib
import math

import numpy as np
import pytest

from ghostball.engine.motion import nodes
from ghostball.engine.motion.nodes import NODES, PARTS, POINT, POINTS, TAKEN, TIMES

EPS = 2.0**-52
ALL = range(len(PARTS))


@pytest.mark.parametrize("part", ALL)
def test_integrals_of_what_turns_a_slip_are_its_logarithm(part):
    """1 / y integrates to -log y, which is singular where the slip ends; so do powers of it."""
    y = 1.0 - TAKEN[part] * TIMES[part]
    found = (TAKEN[part] / y) @ nodes.INTEGRALS[part]
    assert found == pytest.approx(-np.log(y), abs=2e-9 if PARTS[part] < 0.3 else 2e-12)
    assert TAKEN[part] * nodes.TURNED[part] == pytest.approx(found, abs=4 * EPS)
    found = np.ones(NODES) @ nodes.INTEGRALS[part]
    assert found == pytest.approx(TIMES[part], abs=4 * EPS)
    found = TIMES[part] ** 2 @ nodes.INTEGRALS[part]
    assert found == pytest.approx(TIMES[part] ** 3 / 3.0, abs=2e-9 if PARTS[part] < 0.3 else 2e-12)


@pytest.mark.parametrize("part", ALL)
def test_nodes_say_what_is_between_them(part):
    y = 1.0 - TAKEN[part] * TIMES[part]
    found = np.log(y) @ nodes.TO_POINTS[part]
    assert found == pytest.approx(np.log(1.0 - TAKEN[part] * POINT), abs=2e-9)
    assert nodes.TO_POINTS[part].sum(axis=0) == pytest.approx(np.ones(POINTS), abs=8 * EPS)


def test_points_give_the_polynomial_through_them():
    values = np.exp(-POINT)
    powers = values @ nodes.TO_CHEBYSHEV @ nodes.TO_POWERS
    # Of a power its size counts: that of a Chebyshev polynomial of degree 19 is up to 2e14.
    assert np.polyval(powers[::-1], POINT) == pytest.approx(values, abs=0.5)
    degrees = values @ nodes.TO_CHEBYSHEV
    for n in range(POINTS):
        at = np.polynomial.chebyshev.chebval(2.0 * POINT - 1.0, np.eye(POINTS)[n])
        assert degrees[n] == pytest.approx(
            (1.0 if n == 0 else 2.0) / POINTS * float(values @ at), abs=8 * EPS
        )
    exact = nodes.TO_POWERS
    assert np.array_equal(exact, np.round(exact))
    assert exact[-1].sum() == 1.0  # T_19(1)
    assert np.abs(exact).max() < 2.0**53


def test_the_least_slip_is_as_far_off_as_the_ellipse_says():
    for part in ALL:
        z = (1.0 + PARTS[part]) / (1.0 - PARTS[part])
        rho = z + math.sqrt(z * z - 1.0)
        assert nodes.OVER_RHO[part] == pytest.approx(1.0 / rho, rel=4 * EPS)
        assert nodes.FALLS_TO[part] == pytest.approx(rho**-POINTS, rel=1e-13)
        assert nodes.SPAN[part] >= -math.log(PARTS[part])


def test_tables_have_the_same_bits_on_every_machine():
    """They are made of + - * / and square roots; breaks where a library's cosine gets in."""
    digest = hashlib.sha256()
    for name in ("TIMES", "INTEGRALS", "TURNED", "TO_POINTS", "TO_CHEBYSHEV", "TO_POWERS"):
        digest.update(getattr(nodes, name).tobytes())
    assert digest.hexdigest()[:16] == "82be2443992bedcf"
