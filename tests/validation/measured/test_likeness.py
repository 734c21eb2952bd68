"""How like a real table engines can be: best settings, figures, and what they lack."""

from __future__ import annotations

from functools import partial

import pytest
from likenesses import family, likeness as likeness_made_up
from pydantic import ValidationError

from benchmarks.rebounds import ReboundsMeasurement
from ghostball.model import Physics
from ghostball.model.features import Feature
from ghostball.reference_adapters import EngineUnavailableError, make_engine
from ghostball.validation.measured.best import best_cloth, best_cushion, place_of
from ghostball.validation.measured.facts import facts_of
from ghostball.validation.measured.likeness import (
    Family,
    Likeness,
    Measured,
    deceleration,
    likeness,
)


def likeness_of(spec: str) -> dict[str, Family]:
    engine = make_engine(spec)
    found = likeness(spec, engine, partial(engine.simulate, record="trajectory"))
    return {family.name: family for family in found.families}


def test_our_engine_comes_near_to_everything():
    families = likeness_of("ghostball")
    assert set(families) == {"cushion", "cushion-slope", "rolling-pool"}
    assert not any(family.lacks for family in families.values())
    assert families["cushion"].typical < 1.5
    assert families["cushion"].most < 2.5
    assert families["rolling-pool"].most < 1.0
    # A law of two numbers doesn't fall quite as what was measured does.
    assert 2.0 < families["cushion-slope"].most < 3.0


def test_one_restitution_for_all_speeds_is_far_off_and_rises():
    families = likeness_of("pybullet")
    assert families["cushion"].settings["cushion_restitution_loss"] == 0.0
    assert families["cushion"].most > 10.0
    assert all(one.value < 0.0 < one.played for one in families["cushion-slope"].figures)


def test_an_engine_that_turns_no_balls_says_so():
    families = likeness_of("paper-discrete")
    assert families["cushion"].lacks == "it has no law of cushions that turns balls"
    assert families["rolling-pool"].lacks.startswith("it has no sliding that turns into rolling")
    assert families["cushion"].figures == ()


def test_an_engine_that_mentions_few_features_lacks_the_others():
    families = likeness_of("ghostball.validation.examples.stepper:Stepper")
    assert all(family.lacks for family in families.values())


def test_a_ball_that_does_not_bounce_is_said():
    assert "bounced 0 times" in likeness_of("pybullet:config=default")["cushion"].lacks


@pytest.mark.parametrize("name", ["ghostball", "pymunk", "box2d", "pybullet", "mujoco"])
def test_the_best_numbers_are_those_of_the_committed_search(name):
    stored = ReboundsMeasurement.committed()
    assert stored is not None
    try:
        engine = make_engine(name)
    except EngineUnavailableError as error:
        pytest.skip(str(error))
    best = best_cushion(name, engine.capabilities)
    assert best is not None
    falls = engine.capabilities[Feature.FALLING_RESTITUTION].support != "none"
    (found,) = [
        one
        for one in stored.best
        if (one.engine, one.law, one.falls) == (name, best["cushion"], falls)
    ]
    assert best == {"cushion": found.law, "cushion_restitution_loss": 0.0, **found.coefficients}


def test_the_best_cloth_is_nearest_to_what_was_measured():
    ours = make_engine("ghostball").capabilities
    cloth = best_cloth("rolling-carom", ours)
    physics = Physics(preset="carom")
    assert cloth["rolling_friction"] == pytest.approx(physics.rolling_friction, rel=0.02)
    grows = physics.rolling_friction_quadratic
    assert cloth["rolling_friction_quadratic"] == pytest.approx(grows, rel=0.05)
    alone = best_cloth("rolling-carom", make_engine("pybullet").capabilities)
    mean = sum(row.value for row in facts_of("rolling-carom").rows) / 3.0
    assert alone == {
        "rolling_friction": pytest.approx(mean / 9.81),
        "rolling_friction_quadratic": 0.0,
    }


def test_a_deceleration_is_that_of_the_cloth():
    engine = make_engine("ghostball")
    play = partial(engine.simulate, record="trajectory")
    physics = Physics(motion="sliding", rolling_friction=0.01, rolling_friction_quadratic=0.02)
    expected = 0.01 * 9.81 + 0.02 * 0.8**2
    assert deceleration(play, physics, 0.8) == pytest.approx(expected, rel=1e-3)


def test_errors_off_are_those_of_the_measurement():
    assert Measured(at=1.0, value=0.5, error=0.01, played=0.48).errors_off == pytest.approx(-2.0)


def test_a_row_is_in_the_middle_where_it_says_no_more():
    first = facts_of("rolling-pool").rows[0]
    assert place_of(first) == pytest.approx(0.225)


def test_an_engine_as_a_whole_is_where_it_is_furthest_off_of_what_grades():
    graded = likeness_made_up("any", rebound=-2.0, slope=1.0, rolling="it rolls none")
    assert graded.typical == pytest.approx(2.0)
    shown = family("shown", 9.0, grades=False)
    assert Likeness(label="any", families=(*graded.families, shown)).typical == graded.typical
    assert likeness_made_up("any", rolling="it rolls none").typical is None


@pytest.mark.parametrize("fields", [{"figures": ()}, {"lacks": "it rolls none"}])
def test_a_family_has_figures_or_says_why_not(fields):
    with pytest.raises(ValidationError, match="must either have `figures` or say what is lacking"):
        Family(**family("rolling", 1.0).model_dump() | fields)


def test_what_failed_is_told_from_what_is_lacking():
    assert family("rolling", "it failed: it crashed").failed
    assert not family("rolling", "it rolls none").failed
    assert not family("rolling", 1.0).failed
