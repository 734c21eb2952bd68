"""The laws of a scene as numbers for time-stepping engines."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shots import ball, scene_of

from ghostball.engine import simulate
from ghostball.model import Physics, Table
from ghostball.reference_adapters import EngineUnavailableError, make_engine
from ghostball.reference_adapters.stepping.laws import SpeedDependentRestitution

FALLS = {"cushion": "restitution", "cushion_restitution": 0.9, "cushion_restitution_loss": 0.15}


def test_the_restitution_is_that_of_the_speed_towards_the_cushion():
    falling = SpeedDependentRestitution.of(Physics(**FALLS))
    assert falling is not None
    assert falling.at((-1.0, 0.0), (1.44, -3.0)) == 0.9 / (1.0 + 0.15 * math.sqrt(1.44))
    assert falling.at((0.0, -1.0), (1.44, -3.0)) == 0.9  # the ball moves away from this cushion


def test_one_number_is_none_that_falls():
    assert (
        SpeedDependentRestitution.of(Physics(cushion="restitution", cushion_restitution=0.9))
        is None
    )
    assert SpeedDependentRestitution.of(Physics(preset="carom", cushion="mirror")) is None


@pytest.mark.parametrize(
    ("spec", "error"), [("pymunk:contact_steps=exact", 1e-8), ("box2d:contact_steps=exact", 1e-4)]
)
@pytest.mark.parametrize("law", ["restitution", "frictional"])
def test_engines_that_are_asked_for_each_contact_play_it(spec, error, law):
    try:
        engine = make_engine(spec)
    except EngineUnavailableError as missing:
        pytest.skip(str(missing))
    table = Table(length=1.5, width=1.0)
    physics = {**FALLS, "cushion": law, "motion": "sliding"}
    scene = scene_of(ball((0.6, 0.4), (2.0, 0.9)), table=table, **physics)
    fixed = scene_of(
        ball((0.6, 0.4), (2.0, 0.9)), table=table, **(physics | {"cushion_restitution_loss": 0.0})
    )
    truth = simulate(scene).rest_positions
    assert np.linalg.norm(engine.simulate(scene).rest_positions - truth) < error
    assert np.linalg.norm(engine.simulate(fixed).rest_positions - truth) > 0.1
