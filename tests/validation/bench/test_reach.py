"""Fails where a time is claimed that no run and no fit supports, or one that they do is denied."""

import numpy as np
import pytest

from ghostball.validation.bench._reach import Level, order_of, reach_of

TRUTH = np.array([[1.0, 0.5]])
DURATION = 4.0


def ladder(error, *, levels=6, phases=4, wobble=0.0, seconds=1e-3):
    """A ladder of steps 0.02, 0.01, ... whose error along x is `error(step)` m."""
    made = []
    for k in range(levels):
        step = 0.02 / 2**k
        parts = np.array([0.0, 0.5, 0.25, 0.75, 0.125, 0.625, 0.375, 0.875][:phases])
        errors = error(step) + wobble * step * (parts - 0.5)
        states = np.array([TRUTH + np.array([e, 0.0]) for e in errors])
        made.append(Level(step, seconds * 2**k, float(np.abs(errors).max()), states))
    return made


def reached(target, levels, accepts=lambda _: True, lost=()):
    return reach_of(target, levels, order_of(levels, TRUTH), DURATION, accepts, lost)


@pytest.mark.parametrize("order", [1, 2, 4])
def test_the_order_is_found(order):
    assert order_of(ladder(lambda h: 0.3 * h**order), TRUTH).value == pytest.approx(order, abs=0.02)


@pytest.mark.parametrize("wobble", [0.0, 0.2])
def test_the_order_is_found_beneath_a_sawtooth(wobble):
    order = order_of(ladder(lambda h: 0.3 * h, wobble=wobble), TRUTH)
    assert order.value == pytest.approx(1.0, abs=0.2)
    assert order.power == 1.0
    assert order.beside == 0.0


def test_what_was_measured_is_the_cheapest_from_which_on_all_are_as_near():
    levels = ladder(lambda h: 0.3 * h)  # 6, 3, 1.5, 0.75, 0.375, 0.19 mm
    reach = reached(1e-3, levels)
    assert (reach.how, reach.seconds) == ("measured", levels[3].seconds)


def test_a_step_that_is_good_by_luck_does_not_count():
    levels = ladder(lambda h: 0.0 if h == 0.02 else 0.3 * h)
    reach = reached(1e-3, levels)
    assert (reach.how, reach.seconds) == ("measured", levels[3].seconds)


def test_the_worst_phase_counts():
    levels = ladder(lambda h: 0.3 * h, wobble=0.4)
    worst = [level.worst for level in levels]
    assert worst[3] > 0.75e-3 * 1.2
    target = 0.5 * (worst[3] + 0.75e-3)
    assert reached(target, levels).seconds > levels[3].seconds


@pytest.mark.parametrize(("order", "target"), [(1, 1e-6), (2, 1e-9)])
def test_a_time_is_extrapolated_by_the_order(order, target):
    levels = ladder(lambda h: 0.3 * h**order)
    finest = levels[-1]
    reach = reached(target, levels)
    assert reach.how == "extrapolated"
    expected = finest.seconds * (finest.worst / target) ** (1.0 / order)
    assert reach.seconds == pytest.approx(expected, rel=1e-6)
    assert "step of" in reach.note


def test_no_limit_beside_the_truth_is_passed():
    levels = ladder(lambda h: 5e-4 + 0.3 * h)
    order = order_of(levels, TRUTH)
    assert order.value == pytest.approx(1.0, abs=0.02)
    assert order.beside == pytest.approx(5e-4, rel=0.1)
    assert reached(6e-4, levels).how == "extrapolated"
    reach = reached(1e-6, levels)
    assert (reach.how, reach.seconds) == ("never", None)
    assert "beside the truth" in reach.note


def test_terms_of_higher_order_are_no_limit_beside_the_truth():
    order = order_of(ladder(lambda h: 0.3 * h + 4.0 * h**2), TRUTH)
    assert order.beside == 0.0


@pytest.mark.parametrize("target", [1e-3, 1e-6])
def test_nothing_is_reached_where_finer_steps_fail(target):
    reach = reached(target, ladder(lambda h: 0.3 * h), lost=[0.02 / 2**6, 0.02 / 2**7])
    assert (reach.how, reach.seconds) == ("never", None)
    assert reach.note == "it fails at finer steps, such as 1.6e-04 s"


def test_steps_finer_than_one_that_failed_count():
    levels = ladder(lambda h: 0.3 * h)
    reach = reached(3e-3, [*levels[:3], *levels[4:]], lost=[levels[3].step])
    assert (reach.how, reach.seconds) == ("measured", levels[4].seconds)


def test_steps_that_the_engine_refuses_are_never():
    reach = reached(1e-6, ladder(lambda h: 0.3 * h), accepts=lambda step: step >= 1e-5)
    assert reach.how == "never"
    assert "refuses a step of 3.3e-06 s" in reach.note


def test_rounding_of_many_steps_is_a_bound():
    reach = reached(1e-9, ladder(lambda h: 0.3 * h))
    assert reach.how == "never"
    assert "by rounding alone" in reach.note


def test_where_the_step_does_not_matter_nothing_is_extrapolated():
    levels = ladder(lambda _: 1.4e-9)
    assert order_of(levels, TRUTH).value is None
    reach = reached(1e-6, levels)
    assert (reach.how, reach.seconds) == ("measured", levels[0].seconds)
    assert reached(1e-9, levels).how == "never"


def test_what_goes_nowhere_has_no_order():
    levels = ladder(lambda h: 1e-3 * (-1) ** round(np.log2(0.02 / h)))
    order = order_of(levels, TRUTH)
    assert (order.value, order.power) == (None, None)
    assert reached(1e-6, levels).how == "never"


def test_several_orders_that_fit_are_none_and_the_lowest_extrapolates():
    levels = ladder(lambda h: 0.3 * h, wobble=3.0, phases=2)
    order = order_of(levels, TRUTH)
    assert order.value is None
    assert "no order: all from" in order.note
    assert order.power == 1.0


def test_other_courses_at_long_steps_are_left_out():
    levels = ladder(lambda h: 0.3 * h, levels=7)
    lost = [Level(0.02 * 2, 1e-4, 0.5, levels[0].states + 0.5, true_course=False), *levels]
    assert order_of(lost, TRUTH).value == pytest.approx(1.0, abs=0.02)
    few = [*levels[:4], Level(0.02 / 16, 1.0, 0.5, levels[0].states, true_course=False)]
    assert "0 steps play the true course" in order_of(few, TRUTH).note


def test_a_point_is_measured_or_never():
    level = Level(None, 4e-6, 1e-15, np.array([TRUTH]))
    reach = reached(1e-9, [level])
    assert (reach.how, reach.seconds) == ("measured", 4e-6)
    reach = reached(1e-16, [level])
    assert (reach.how, reach.note) == ("never", "no step: a point")


def test_an_interrupt_leaves_phases_of_which_the_evenly_spread_are_fitted():
    assert order_of(ladder(lambda h: 0.3 * h, phases=3), TRUTH).value == pytest.approx(
        1.0, abs=0.02
    )
