"""The events that a time step may delay, and those that it can't delay."""

from __future__ import annotations

import pytest
from engine_facts import needs
from step_rules import criteria_of_step, limit_of_step

from ghostball.model import Ball, Physics, Scene
from ghostball.reference_adapters import make_engine
from ghostball.validation.scenes.library import find_scene

pytest.importorskip("pymunk")


@pytest.mark.parametrize(
    ("name", "label", "why"),
    [
        ("galperin-2", "pymunk", "a step holds many collisions of a ball"),
        ("unbounded-cut", "paper-discrete", "in a step balls go more than a radius"),
        ("break-7", "pymunk", "the engine's errors lead the shot onto another path"),
        ("three-ball-symmetric", "pymunk", "two collisions of one instant have no derivative"),
        pytest.param(
            "push", "pybullet", "a contact that lasts isn't proved", marks=needs("pybullet")
        ),
    ],
)
def test_the_rest_error_has_no_limit_if_delays_are_not_its_only_cause(
    name: str, label: str, why: str
) -> None:
    assert limit_of_step(find_scene(name), label) is None, why


def test_collisions_of_different_balls_within_a_step_have_no_order() -> None:
    scene = find_scene("throw-by-angle")
    fixed = {one.metric for one in criteria_of_step(scene, make_engine("pymunk:dt=5e-4"))}
    assert "ball_ball_count_error" in fixed
    assert "matching_events" not in fixed
    exact = criteria_of_step(scene, make_engine("pymunk:contact_steps=exact"))
    assert "matching_events" in {one.metric for one in exact}


@pytest.mark.parametrize(
    "name",
    [
        "break-7",  # a ball hits two balls within one step
        "break-16",  # the error of one step grows to a radius at once
        "frozen-triangle",  # the proof ends when touching balls are hit
    ],
)
def test_the_first_collision_is_asked_where_the_end_cannot_be_judged(name: str) -> None:
    scene = find_scene(name)
    for label in ("pymunk", "pymunk:dt=1e-4"):
        (first,) = (
            one
            for one in criteria_of_step(scene, make_engine(label))
            if one.metric == "matching_events"
        )
        assert (first.limit_kind, first.limit) == ("at_least", 1), label


def test_the_collisions_before_a_tie_are_asked_in_their_order() -> None:
    # "b" hits "c" at 0.3 s; a second later, "a" hits "d" and "e" simultaneously.
    balls = [
        Ball(id="a", position=(0.0, 0.0), velocity=(1.0, 0.0)),
        Ball(id="d", position=(1.0, 0.03)),
        Ball(id="e", position=(1.0, -0.03)),
        Ball(id="b", position=(0.0, 0.7), velocity=(1.0, 0.0)),
        Ball(id="c", position=(0.3, 0.7)),
    ]
    physics = Physics(preset="paper", rolling_friction=0.0)
    scene = Scene(name="tie", physics=physics, balls=balls, t_max=3.0)
    found = criteria_of_step(scene, make_engine("pymunk:dt=1e-3"))
    limits = [(one.limit_kind, one.limit) for one in found if one.metric == "matching_events"]
    assert limits == [("at_least", 1)]
    assert "rest_error_max" not in {one.metric for one in found}
