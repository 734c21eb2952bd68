"""Fits of an artificial model with a known answer, without any shot."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from ghostball.model import Physics
from ghostball.validation.measured.fit.least_squares import (
    HUBER,
    Assumed,
    Field,
    FitProblem,
    covariance_of,
    goodness,
)

NOISE = 0.01
NAMES = ("rolling_friction", "sliding_friction")
FRICTION = Field("rolling_friction", 0.0, 0.2, 1e-3, frozenset({"made"}))
SLIDING = Field("sliding_friction", 0.0, 1.0, 1e-3, frozenset({"made"}))


@dataclass
class Made:
    """An event with the measured values of z and of a + b z^2, which have equal errors."""

    shot: str
    given: np.ndarray
    seen: np.ndarray
    hides_side: bool = False
    given_covariance: np.ndarray = field(default_factory=lambda: np.array([[NOISE**2]]))
    seen_covariance: np.ndarray = field(default_factory=lambda: np.array([[NOISE**2]]))

    @property
    def guesses(self):
        return [self.given]

    @property
    def steps(self):
        return np.array([NOISE])


def predict(physics, played):
    return [physics.rolling_friction + physics.sliding_friction * z**2 for _, z in played]


def build(values):
    return Physics(motion="sliding", **dict(zip(NAMES, values, strict=True)))


def made(seed, count=40, spoilt=0):
    random = np.random.default_rng(seed)
    z = random.uniform(0.5, 2.0, count)
    seen = 0.05 + 0.3 * z**2 + random.normal(0.0, NOISE, count)
    seen[:spoilt] += 20.0 * NOISE
    given = z + random.normal(0.0, NOISE, count)
    return [
        Made(str(k), np.array([a]), np.array([b]))
        for k, (a, b) in enumerate(zip(given, seen, strict=True))
    ]


def solved(events):
    problem = FitProblem(events, [FRICTION, SLIDING], build, predict)
    return problem.solve(np.array([0.1, 0.2]))


@pytest.fixture(scope="module")
def solutions():
    return [solved(made(seed)) for seed in range(100)]


def test_errors_on_both_sides_are_taken_into_account(solutions):
    off = np.array([(one.values - [0.05, 0.3]) / one.errors for one in solutions])
    # The expected number is 95 of 100; the probability of fewer than 88 or more than 99 is 0.001.
    held = np.sum(np.abs(off) < 1.96, axis=0)
    assert np.all((held >= 88) & (held <= 99))
    assert np.abs(off.mean(axis=0)) == pytest.approx([0.0, 0.0], abs=0.35)


def test_the_goodness_is_1_where_only_noise_is_left(solutions):
    assert np.mean([goodness([one]) for one in solutions]) == pytest.approx(1.0, abs=0.1)


def test_a_search_that_stalls_has_not_settled(solutions):
    assert all(one.settled for one in solutions)

    def misleading(physics, played):
        """Return values that fall only near the point at which the derivative is computed."""
        off = abs(physics.rolling_friction - 0.1)
        dip = 2e-5 if abs(off - FRICTION.step) < FRICTION.step / 10.0 else 0.0
        return [np.array([1.0 + 1e-3 * off - dip]) for _ in played]

    events = [Made(str(k), np.array([1.0]), np.array([0.0])) for k in range(40)]
    found = FitProblem(
        events, [FRICTION], lambda values: build([values[0], 0.2]), misleading
    ).solve(np.array([0.1]))
    assert found.values[0] == 0.1
    assert not found.settled


def test_events_that_are_spoilt_move_the_values_little():
    clean, spoilt = solved(made(3)), solved(made(3, spoilt=4))
    assert np.all(np.abs(clean.values - spoilt.values) < 3.0 * clean.errors)
    assert goodness([spoilt]) > 2.0


def test_a_value_stays_within_its_bounds():
    low = Field("rolling_friction", 0.06, 0.2, 1e-3, frozenset({"made"}))
    problem = FitProblem(made(1), [low, SLIDING], build, predict)
    assert problem.solve(np.array([0.1, 0.2])).values[0] == pytest.approx(0.06)


def test_an_assumption_that_no_event_tells_adds_its_own_error():
    """The sum a + b is measured and b is assumed, so the error of a contains both errors."""
    slopes, random = np.ones((400, 2)), np.random.default_rng(2)
    left, shots = random.normal(0.0, 1.0, 400), [str(k) for k in range(400)]
    found = covariance_of(slopes, left, shots, np.array([0.0, 0.5**-2]))
    assert found[1, 1] == pytest.approx(0.5**2)
    assert found[0, 0] == pytest.approx(0.5**2 + 1.0 / 400.0, rel=0.01)
    assert found[0, 1] == pytest.approx(-(0.5**2), rel=0.01)


def test_an_assumption_is_moved_by_events_that_tell_better():
    assumed = {"rolling_friction": Assumed(0.1, 0.05)}  # the true value is 0.05
    problem = FitProblem(made(1), [FRICTION, SLIDING], build, predict, assumed)
    found, alone = problem.solve(np.array([0.1, 0.2])), solved(made(1))
    assert found.values == pytest.approx(alone.values, abs=0.2 * np.max(alone.errors))
    firm = {"rolling_friction": Assumed(0.1, 1e-6)}
    problem = FitProblem(made(1), [FRICTION, SLIDING], build, predict, firm)
    assert problem.solve(np.array([0.1, 0.2])).values[0] == pytest.approx(0.1, abs=1e-5)


def test_the_error_of_a_field_that_no_event_tells_is_infinite():
    problem = FitProblem(
        made(1), [FRICTION, SLIDING], lambda values: build([values[0], 0.3]), predict
    )
    found = problem.solve(np.array([0.1, 0.2]))
    assert found.values[1] == pytest.approx(0.2)
    assert np.isinf(found.errors[1])
    assert 0.0 < found.errors[0] < 0.01


def test_numbers_of_one_shot_count_once():
    random = np.random.default_rng(1)
    slopes, left = np.ones((50, 1)), random.normal(0.0, 1.0, 50)
    alone = covariance_of(slopes, left, [str(k) for k in range(50)])
    twice = covariance_of(
        np.repeat(slopes, 2, axis=0), np.repeat(left, 2), [str(k // 2) for k in range(100)]
    )
    assert twice == pytest.approx(alone)
    assert np.sqrt(alone[0, 0]) == pytest.approx(1.0 / np.sqrt(50), rel=0.3)


def test_a_large_residual_counts_by_its_size():
    solution = solved(made(3, spoilt=1))
    (spoilt,) = solution.residuals[0]
    assert solution.misfits[0] == pytest.approx(2.0 * HUBER * abs(spoilt) - HUBER**2)
