"""The motion of a scene depends on its exact numbers, and not on names."""

from __future__ import annotations

import math

import pytest
from shots import POOL_TABLE, ball, scene_of

from ghostball.model import Table
from ghostball.reference_adapters.certified.problem import problem_of
from ghostball.validation.scenes.library import find_scene


def shot(**fields):
    return scene_of(ball((0.5, 0.6), (1.0, 0.2)), ball((1.0, 0.7)), **fields)


def test_names_titles_and_tags_are_no_part_of_it():
    scene = shot(table=POOL_TABLE)
    renamed = scene.model_copy(update={"name": "other", "title": "Other", "tags": ("other",)})
    assert problem_of(renamed) == problem_of(scene)


@pytest.mark.parametrize("field", ["gravity", "rolling_friction", "ball_restitution"])
def test_an_ulp_is_another_problem(field):
    scene = shot(ball_restitution=0.9)
    off = math.nextafter(getattr(scene.physics, field), 0.0)
    assert problem_of(shot(**{"ball_restitution": 0.9, field: off})) != problem_of(scene)


def test_cushions_are_lines_where_they_are_and_mirrors_have_factors_of_1():
    problem = problem_of(shot(table=Table(length=2.0, width=1.0, cushions=("right", "bottom"))))
    assert problem.noses == (None, 2.0, 0.0, None)
    assert problem.obstacles == ()
    mirror = problem_of(shot(preset="carom", cushion="mirror", table=POOL_TABLE))
    assert (mirror.cushion_restitution, mirror.cushion_loss, mirror.cushion_tangential) == (1, 0, 1)


def test_a_law_of_friction_is_no_number():
    assert problem_of(find_scene("throw-alciatore")).ball_friction is None
    assert problem_of(find_scene("throw-slip")).ball_friction == 0.06
