"""Impact laws for wide intervals, which may contain 0.

`test_api.py` compares the laws with the oracle in whole shots.
"""

from __future__ import annotations

import pytest
from flint import arb
from shots import R, ball, scene_of

from ghostball.model import Table
from ghostball.reference_adapters.certified.arithmetic import UndecidedError, working_precision
from ghostball.reference_adapters.certified.laws import ImpactLaws, InContactFrame
from ghostball.reference_adapters.certified.problem import problem_of


def scene(friction, cushion, masses=(0.17, 0.2)):
    balls = [ball((0.5, 0.5 + k), mass=m, radius=R * (1 + k / 8)) for k, m in enumerate(masses)]
    return scene_of(
        *balls,
        table=Table(length=3.0, width=3.0),
        motion="sliding",
        ball_restitution=0.9375,
        ball_friction=friction,
        **cushion,
    )


def test_equal_elastic_balls_swap_their_speeds_exactly():
    one = scene_of(ball((0.0, 0.0)), ball((1.0, 0.0)))
    with working_precision(53):
        zero, third = arb(0), arb(1) / 3
        cue = InContactFrame(third, zero, zero, zero, zero, arb(R))
        rest = InContactFrame(zero, zero, zero, zero, zero, arb(R))
        a, b = ImpactLaws(problem_of(one)).collide(0, 1, cue, rest)
        assert a.vn.is_zero()
        assert b.vn.contains(third.mid())


def test_a_slip_that_may_be_nothing_is_ended_by_friction():
    # At the boundary of sticking and slipping, both impulses are equal, so no decision is needed.
    one = scene(0.0625, {"cushion": "mirror"}, masses=(0.17, 0.17))
    with working_precision(106):
        laws, zero = ImpactLaws(problem_of(one)), arb(0)
        a = InContactFrame(arb(1), arb(0, 1e-20), arb(1), arb(0, 1e-20), zero, arb(R))
        b = InContactFrame(zero, zero, -arb(1), zero, zero, arb(R))
        after, _ = laws.collide(0, 1, a, b)
        assert abs(after.vt) < 1e-19


def test_whether_a_cushion_stops_a_ball_may_be_undecided():
    one = scene(0.0, {"cushion": "han2005", "cushion_restitution": 0.0, "cushion_friction": 0.0})
    with working_precision(53):
        laws = ImpactLaws(problem_of(one))
        zero = arb(0)
        with pytest.raises(UndecidedError, match="whether the cushion stops it"):
            laws.bounce(0, InContactFrame(arb(0, 1e-3), zero, zero, zero, zero, arb(R)))
