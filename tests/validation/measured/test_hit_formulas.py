"""Closed forms of hits: known limits, agreement with our engine, and errors from their inputs."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import Physics
from ghostball.validation.measured.facts import facts_of
from ghostball.validation.measured.hit_formulas import (
    directions_after_hit,
    speeds_after_head_on_hit,
    uncertainty,
)
from ghostball.validation.measured.oblique_hits import head_on_hit
from ghostball.validation.measured.simulated_ball import OperatorError
from ghostball.validation.measured.table_agreement import SPEED_OF_HITS, material_hits

PLAY = partial(simulate, record="trajectory")


@pytest.mark.parametrize("cut", [10.0, 33.0, 60.0, 80.0])
def test_elastic_balls_without_friction_do_as_wallace_and_schroeder_say(cut):
    sine, cosine = math.sin(math.radians(cut)), math.cos(math.radians(cut))
    deflection = math.degrees(math.atan2(sine * cosine, sine**2 + 0.4))
    assert directions_after_hit(1.0, 0.0, cut) == pytest.approx([deflection, 0.0], abs=1e-12)


@pytest.mark.parametrize("row", facts_of("hits-materials").rows, ids=lambda row: row.what)
def test_our_engine_gives_the_directions_of_the_formula(row):
    """Contacts slip, except for rubber balls, whose contact sticks."""
    physics = Physics(motion="sliding", ball_restitution=row.value, ball_friction=row.place)
    for figure in (one for hit in material_hits(PLAY, physics, row) for one in hit):
        assert figure.played == pytest.approx(figure.value, abs=2e-3)
        assert 0.05 < figure.error < 2.0


@pytest.mark.parametrize("row", facts_of("hits-unequal").rows, ids=lambda row: row.what)
def test_our_engine_gives_the_speeds_of_the_formula(row):
    physics = Physics(motion="sliding", ball_restitution=row.value, ball_friction=0.11)
    speeds = np.array(head_on_hit(PLAY, physics, SPEED_OF_HITS, row.place)) / SPEED_OF_HITS
    assert speeds == pytest.approx(speeds_after_head_on_hit(row.value, row.place), abs=1e-3)
    assert row.place * speeds[0] + speeds[1] == pytest.approx(row.place, abs=2e-3)


def test_the_error_of_an_input_is_carried_through():
    formula = partial(speeds_after_head_on_hit, mass_ratio=3.0)
    assert uncertainty(formula, (0.6,), (0.02,)) == pytest.approx([0.02 / 4.0, 0.02 * 3.0 / 4.0])


def test_errors_of_two_inputs_add_as_in_random_draws():
    formula = partial(directions_after_hit, cut=40.0)
    chance = np.random.default_rng(1)
    drawn = [formula(*chance.normal((0.92, 0.14), (0.02, 0.02))) for _ in range(4000)]
    carried = uncertainty(formula, (0.92, 0.14), (0.02, 0.02))
    assert carried == pytest.approx(np.std(drawn, axis=0), rel=0.05)


def test_a_ball_that_is_not_hit_is_said():
    def too_short(scene):
        return PLAY(scene.model_copy(update={"t_max": 1e-4}))

    with pytest.raises(OperatorError, match=r"after a head-on hit at 0\.75 m/s"):
        head_on_hit(too_short, Physics(motion="sliding"), 0.75, 1.0)
