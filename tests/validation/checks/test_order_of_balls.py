"""The order of the balls changes no bit of a result, where Ghostball's engine promises this."""

from __future__ import annotations

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Scene, Table
from ghostball.validation.checks.related_shots import (
    depends_on_order,
    hits_two_in_turn,
    renumber,
)
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.scenes.random_scenes import random_scene


def landing_on_two(apart: float) -> Scene:
    """Return a ball that falls on two others, `apart` [m] nearer to the second."""
    radius = 0.03
    balls = [
        Ball(id="falls", position=(apart, 0.0, 0.15), velocity=(0.0, 0.0, -0.1), radius=radius),
        Ball(id="left", position=(-0.04, 0.0, radius), radius=radius),
        Ball(id="right", position=(0.04, 0.0, radius), radius=radius),
    ]
    return Scene(
        name="fall", t_max=0.15, physics=Physics(preset="pool", airborne=True), balls=balls
    )


LASTING_HIT = Scene(
    name="lasting",
    t_max=1.0,
    physics=Physics(rolling_friction=0.0, impacts="compliant"),
    balls=[
        Ball(id="a", position=(0.0, 0.0), velocity=(1.0, 0.0)),
        Ball(id="b", position=(0.2, 0.0)),
        Ball(id="c", position=(0.25715, 0.0)),
    ],
)

ORDERS = {
    "contact steps": (random_scene(2178), "contact_steps", True),
    "impacts that last": (LASTING_HIT, "compliant_impacts", True),
    "two hits in flight at once": (landing_on_two(0.0), None, True),
    "two hits in flight, one first": (landing_on_two(0.001), None, False),
    "one hit on the cloth": (find_scene("half-ball-cut"), None, False),
}


@pytest.mark.parametrize(("scene", "counter", "depends"), ORDERS.values(), ids=ORDERS.keys())
def test_the_order_of_balls_may_change_bits(
    scene: Scene, counter: str | None, depends: bool
) -> None:
    run = simulate(scene, record="trajectory")
    assert depends_on_order(run) == depends
    if counter is not None:
        assert run.work[counter] > 0
    else:
        assert hits_two_in_turn(run) == depends


def test_a_ball_that_leans_on_another_moves_alike_in_any_order_of_balls() -> None:
    table = Table(length=0.8, width=0.5)
    physics = Physics(
        preset="pool",
        airborne=True,
        rolling_friction=0.027819651493002202,
        ball_restitution=0.0,
        ball_friction=0.0,
        cushion="restitution",
        cushion_restitution=1.0,
        cushion_tangential_restitution=0.4482558354936399,
        cushion_height=0.029055195534047097,
        table_restitution=0.39919803501842355,
    )
    leans = Ball(
        id="leans",
        position=(0.5012518962888337, 0.02762774631141641, 0.02765620067604661),
        velocity=(0.00949952104378876, -0.00041300481310818, -0.01390932060046958),
        angular_velocity=(4.5658412168323625, 0.8780448095384247, 0.0),
        radius=0.027654522094617648,
        mass=0.09028596711703286,
    )
    slides = Ball(
        id="slides",
        position=(0.4904889056386631, 0.07576737831874004),
        velocity=(-0.046206927018444775, -0.010777550811043746),
        angular_velocity=(4.951523307972039, -1.1583978412777796, 0.0),
        radius=0.02199664543250208,
        mass=0.20084258680078165,
    )
    scene = Scene(name="leans", t_max=0.04, table=table, physics=physics, balls=[leans, slides])
    run = simulate(scene, record="trajectory")
    renumbered = renumber(run)
    other = simulate(renumbered.scene, record="trajectory")
    times = np.union1d(run.events["t"], np.linspace(0.0, run.rest_time, 65))
    positions = renumbered.expected(times, other.sample(times).positions)
    np.testing.assert_array_equal(positions, run.sample(times).positions)
    np.testing.assert_array_equal(other.events["t"], run.events["t"])
