"""The rational line, against what is known of it."""

from __future__ import annotations

from fractions import Fraction

import pytest

from ghostball.validation.stress.exact_line import play_line

R = 2.0**-5


def test_equal_elastic_balls_trade_velocities():
    end = play_line([0.0, 0.25, 0.5], [1.0, 0.0, 0.0], [1.0] * 3, R, 1.0, 1.0)
    assert end.velocities == [0, 0, 1]
    # Each ends where it met the next one; the last has what is left of the way.
    assert end.positions == [Fraction(3, 16), Fraction(7, 16), Fraction(9, 8)]
    assert end.collisions == 2
    assert end.least_gap == Fraction(3, 16)


@pytest.mark.parametrize("e", [0.0, 0.5, 0.75])
def test_momentum_stays_and_the_balls_part_at_e_times_the_approach(e):
    masses = [1.0, 2.0]
    end = play_line([0.0, 0.25], [1.0, -0.5], masses, R, e, 1.0)
    assert end.velocities[1] - end.velocities[0] == Fraction(e) * Fraction(3, 2)
    assert sum(m * v for m, v in zip(map(Fraction, masses), end.velocities, strict=True)) == 0


def test_nothing_happens_before_it_is_due():
    end = play_line([0.0, 0.25], [1.0, 0.0], [1.0] * 2, R, 1.0, 0.1875)
    assert end.collisions == 0
    assert end.velocities == [1, 0]


def test_what_is_a_convention_is_refused():
    with pytest.raises(ValueError, match="at one instant"):
        play_line([0.0, 0.25, 0.5], [1.0, 0.0, -1.0], [1.0] * 3, R, 1.0, 1.0)
