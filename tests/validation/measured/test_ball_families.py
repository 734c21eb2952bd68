"""Families of hits: speeds and ways after oblique ones, and throw; shown, but not graded."""

from __future__ import annotations

from functools import partial

import pytest

from ghostball.reference_adapters import make_engine
from ghostball.validation.measured.ball_families import oblique_hits, throw


def of(spec, families):
    engine = make_engine(spec)
    return families(engine, partial(engine.simulate, record="trajectory"))


@pytest.mark.parametrize("spec", ["ghostball", "pymunk", "pybullet"])
def test_hits_are_off_by_some_percent_and_degrees(spec):
    speeds, angle = of(spec, oblique_hits)
    assert not speeds.grades
    assert not angle.grades
    assert {one.what for one in speeds.figures} == {"cue ball", "object ball"}
    assert len(speeds.figures) == 2 * len(angle.figures) == 10
    assert 0.02 < speeds.typical_difference < 0.04
    assert 1.0 < angle.typical_difference < 3.0
    assert speeds.settings == {"ball_restitution": 0.89, "ball_friction": 0.05}


def test_the_hit_that_differs_from_all_models_is_one():
    # A cut of 33.83 degrees; the authors' model is as far off there.
    _, angle = of("ghostball", oblique_hits)
    off = sorted(abs(one.difference) for one in angle.figures)
    assert off[-2] < 1.2
    assert off[-1] > 4.0


def test_no_friction_throws_as_far_as_was_measured_at_small_cuts():
    family = of("ghostball", throw)
    assert not family.grades
    assert len(family.figures) == 6
    assert all(one.difference < -2.0 for one in family.figures)
    assert family.settings["ball_friction"] == "alciatore"
    assert of("pybullet", throw).settings["ball_friction"] == 0.06


def test_an_engine_whose_balls_only_roll_says_so():
    speeds, angle = of("paper-continuous", oblique_hits)
    assert speeds.lacks.startswith("it has no sliding that turns into rolling")
    assert angle.lacks == speeds.lacks
    assert of("paper-continuous", throw).lacks.startswith("it has no sliding")
