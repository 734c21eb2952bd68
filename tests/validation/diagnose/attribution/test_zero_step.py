"""The bound of where balls end at zero step, for errors whose limit is known."""

import numpy as np
import pytest

from ghostball.validation.diagnose.attribution._runs import FINEST, ladder_of
from ghostball.validation.diagnose.attribution._zero_step import (
    LEAST_RATIO,
    MARGIN,
    RUNS,
    zero_step_of,
)

LIMIT = np.array([[1.0, 2.0], [0.3, 0.4]])
WAY = np.array([[0.6, -0.8], [0.0, 0.1]])
"""A direction: the first ball's is of length 1, the other's shorter."""

DURATIONS = [100.0, 3.0, 0.5]
"""Of shots [s] whose ladders end at 1/8, 1/64 and 1/256 of a step of 1 ms."""


def limit_for(error, duration=3.0):
    """The limit that is found of an error of so many metres at each step [s]."""
    steps = ladder_of(1e-3, duration, None)
    return zero_step_of(steps, [LIMIT + error(h) * WAY for h in steps])


def off(limit):
    return np.hypot(*(limit.positions - LIMIT).T).max()


@pytest.mark.parametrize("duration", DURATIONS)
@pytest.mark.parametrize("order", [0.75, 1.0, 1.5, 2.0, 4.0])
def test_errors_that_fall_by_any_order_from_three_quarters_on_are_covered(order, duration):
    limit = limit_for(lambda h: 3.0 * h**order, duration)
    assert off(limit) <= limit.uncertainty
    assert limit.falls


@pytest.mark.parametrize("second", [-0.4, 0.4])
def test_a_second_order_that_hides_a_part_of_the_first_is_covered(second):
    limit = limit_for(lambda h: h * (1.0 + second * h / 1e-3))
    assert off(limit) <= limit.uncertainty


@pytest.mark.parametrize("contacts", [1, 2, 5])
@pytest.mark.parametrize("duration", DURATIONS)
def test_contacts_seen_late_by_a_random_part_of_a_step_are_covered(contacts, duration):
    random = np.random.default_rng(3)
    shots, outside, rising = 400, 0, 0
    for _ in range(shots):
        ways = random.normal(size=(contacts, 2, 2))
        steps = ladder_of(1e-3, duration, None)
        late = random.random((len(steps), contacts)) * np.array(steps)[:, np.newaxis]
        limit = zero_step_of(steps, [LIMIT + np.tensordot(one, ways, 1) for one in late])
        outside += off(limit) > limit.uncertainty
        rising += not limit.falls
    assert outside <= 0.01 * shots  # the margin leaves far less than one in twenty
    assert rising <= 0.01 * shots


def test_the_largest_of_twenty_is_outside_at_most_without_the_margin():
    """Errors drawn alike whose greatest can be anything: one in twenty is the bound."""
    random = np.random.default_rng(5)
    steps = np.array(ladder_of(1e-3, 3.0, None))
    shots, outside = 2000, 0
    for _ in range(shots):
        errors = steps * random.pareto(1.0, len(steps))
        limit = zero_step_of(steps.tolist(), [LIMIT + e * WAY for e in errors])
        outside += off(limit) > limit.uncertainty / MARGIN
    assert outside <= 0.05 * shots * 1.2  # counted, so within three deviations of one in twenty


@pytest.mark.parametrize("duration", DURATIONS)
def test_errors_that_do_not_fall_are_seen(duration):
    there_and_back = iter([1e-3, -1e-3] * RUNS)
    wobbling = limit_for(lambda _: next(there_and_back), duration)
    assert not wobbling.falls
    assert wobbling.uncertainty >= 1e-3


def test_states_that_no_step_changes_have_no_uncertainty():
    limit = limit_for(lambda _: 0.0)
    assert (limit.uncertainty, limit.spread, limit.falls) == (0.0, 0.0, True)


@pytest.mark.parametrize(
    ("duration", "finest"), [(100.0, 8), (4.0, 16), (3.0, 32), (2.0, 64), (0.1, 256)]
)
def test_a_ladder_is_as_fine_as_it_may_cost(duration, finest):
    steps = ladder_of(1e-3, duration, None)
    assert len(steps) == RUNS + 1
    assert steps[0] == 1e-3
    assert steps[0] / steps[-1] == pytest.approx(finest)
    assert finest in FINEST
    assert np.all(np.diff(steps) < 0.0)
    assert steps[-2] / steps[-1] == pytest.approx(LEAST_RATIO)


@pytest.mark.parametrize("end", [1e-4, 1e-3, 2.7e-3, 1.0])
def test_steps_divide_the_time_to_a_given_end(end):
    steps = np.array(ladder_of(1e-3, end, end))
    np.testing.assert_allclose(end / steps, np.round(end / steps), rtol=1e-12)
    assert steps[-1] * LEAST_RATIO <= steps[:-1].min() * (1 + 1e-12)
