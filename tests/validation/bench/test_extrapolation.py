"""Extrapolation to zero step: of sequences whose limit and order are known."""

import numpy as np
import pytest

from ghostball.validation.bench._extrapolation import extrapolate
from ghostball.validation.diagnose.attribution import largest_distance

STEPS = [0.02 / 2**k for k in range(5)]
LIMIT = np.array([[1.0, 2.0], [0.3, 0.4]])
SLOPE = np.array([[0.5, -0.2], [0.0, 0.1]])


def ladder(order, phases=1, noise=0.0):
    """States that go to LIMIT in an order; `noise` spreads a sawtooth over the start phases."""
    return [
        np.array([LIMIT + SLOPE * (h**order + noise * h * (j / phases)) for j in range(phases)])
        for h in STEPS
    ]


@pytest.mark.parametrize("order", [1.0, 2.0, 3.0])
def test_a_known_order_and_its_limit_are_found(order):
    fit = extrapolate(STEPS, ladder(order), LIMIT)
    assert fit.outcome == "fitted"
    assert fit.order == pytest.approx(order, abs=0.01)
    assert fit.order_low - 1e-9 <= order <= fit.order_high + 1e-9
    np.testing.assert_allclose(fit.limit, LIMIT, atol=1e-9)
    assert fit.uncertainty < 1e-8


def test_an_order_that_is_no_whole_number_is_kept():
    fit = extrapolate(STEPS, ladder(1.5), LIMIT)
    assert fit.order_used == pytest.approx(1.5, abs=0.01)
    np.testing.assert_allclose(fit.limit, LIMIT, atol=1e-4)


@pytest.mark.parametrize("phases", [(4, 3, 2, 1), (6, 6, 6, 6, 6)])
def test_the_limit_lies_within_its_uncertainty_where_start_phases_scatter(phases):
    # Contacts seen late by what is left of the step: evenly spread phases of an unknown offset.
    random = np.random.default_rng(7)
    outside = 0
    for _ in range(12):  # fifty come hardly nearer to the uncertainty: 0.73 of it against 0.67
        states = [
            np.array([LIMIT + SLOPE * h * ((j / p + offset) % 1.0) for j in range(p)])
            for h, p, offset in zip(STEPS, phases, random.random(len(STEPS)), strict=False)
        ]
        fit = extrapolate(STEPS[: len(phases)], states, LIMIT)
        outside += largest_distance(fit.limit, LIMIT) > fit.uncertainty
    assert outside == 0


def test_states_that_a_step_does_not_move_are_flat():
    states = [np.array([LIMIT + 1e-12 * k]) for k in range(5)]
    fit = extrapolate(STEPS, states, LIMIT + 1e-3)
    assert fit.outcome == "flat"
    assert fit.order is None
    assert fit.uncertainty < 1e-11


@pytest.mark.parametrize(
    "states",
    [
        pytest.param(
            [np.array([LIMIT + SLOPE * (-1) ** k]) for k in range(5)], id="back and forth"
        ),
        pytest.param([np.array([LIMIT + SLOPE * k]) for k in range(5)], id="away"),
        pytest.param([np.array([LIMIT - SLOPE / h]) for h in STEPS], id="faster and faster"),
    ],
)
def test_what_has_no_limit_is_not_converged(states):
    assert extrapolate(STEPS, states, LIMIT).outcome == "not converged"


def test_three_levels_say_nothing():
    assert extrapolate(STEPS[:3], ladder(1.0)[:3], LIMIT).outcome == "not converged"
