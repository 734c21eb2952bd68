"""The ends of steps: at equal times, at the end of a run, or at contacts."""

from __future__ import annotations

import numpy as np
import pytest
from shots import R, ball, scene_of

from ghostball.reference_adapters.stepping.step_ends import (
    BallMotion,
    Clock,
    ExactSteps,
    StepsToContacts,
)

TWO = scene_of(ball((0, 0), (1, 0)), ball((0.5, 0)))


def moving(x: float, speed: float = 1.0, lasts: float = np.inf) -> BallMotion:
    """Return the first ball of `TWO` at a position, on a cloth without friction."""
    positions, velocities = np.array([[x, 0.0], [0.5, 0.0]]), np.array([[speed, 0.0], [0.0, 0.0]])
    return BallMotion(positions, velocities, np.zeros((2, 2)), np.full(2, R), lasts)


def never() -> BallMotion:
    raise AssertionError("equal steps ask for no motion")


@pytest.mark.parametrize(
    ("dt", "t_end", "count"), [(0.1, 0.3, 3), (1e-3, 1.0, 1000), (0.4, 1.0, 3), (5.0, 1.0, 1)]
)
def test_steps_are_equal_no_longer_than_asked_and_end_on_the_end(
    dt: float, t_end: float, count: int
) -> None:
    clock = Clock(dt, t_end)
    assert clock.dt <= dt * (1.0 + 1e-12)
    ends = [clock.next(0.0, never) for _ in range(count)]
    assert ends[-1] == (clock.dt, t_end, False)
    # Multiples of the step, because the rounding of a running sum would grow.
    assert ends[:-1] == [(clock.dt, k * clock.dt, False) for k in range(1, count)]


def test_a_step_ends_just_before_a_contact_and_the_next_one_just_after() -> None:
    steps, contact = StepsToContacts(TWO, ExactSteps(), 1.0, 9.0), 0.5 - 2 * R
    dt, t, touches = steps.next(0.0, lambda: moving(0.0))
    assert (t, touches) == (dt, True)
    assert contact - dt == pytest.approx(1e-10, rel=1e-3)
    over, _, touches = steps.next(t, lambda: moving(dt))
    assert touches
    assert dt + over - contact == pytest.approx(1e-10, rel=1e-3)


@pytest.mark.parametrize(
    ("longest", "lasts", "t_end", "end"),
    [(0.1, 9.0, 9.0, 0.1), (1.0, 0.2, 9.0, 0.2), (1.0, 9.0, 0.3, 0.3), (1.0, 0.3, 0.3005, 0.3005)],
)
def test_a_step_without_a_contact_ends_at_its_length_a_change_or_the_end(
    longest: float, lasts: float, t_end: float, end: float
) -> None:
    """A remainder that is too short for a step isn't a separate step."""
    steps = StepsToContacts(TWO, ExactSteps(shortest=1e-3), longest, t_end)
    assert steps.next(0.0, lambda: moving(0.0, lasts=lasts)) == (end, end, False)


def test_no_step_is_shorter_than_the_engine_makes() -> None:
    steps = StepsToContacts(TWO, ExactSteps(shortest=1e-3), 1.0, 9.0)
    assert steps.next(1.0, lambda: moving(0.0, 1e6)) == (1e-3, 1.001, True)
