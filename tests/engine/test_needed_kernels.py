"""Tests of the variants of the kernels that scenes need."""

import math

import pytest
from shots import ball, crowded_table, scene_of

from ghostball.engine import simulate, warm_up
from ghostball.engine.needed_kernels import every_kernel, kernels_of

ONE = scene_of(ball((0.0, 0.0), (1.0, 0.0)))
TWO = scene_of(ball((0.0, 0.0), (1.0, 0.0)), ball((1.0, 0.0)))
IN_AIR = scene_of(ball((0.0, 0.0), (1.0, 0.0)), air_drag=0.004)
INTEGRATED = scene_of(
    ball((0.0, 0.0), (1.0, 0.0)),
    ball((1.0, 0.0)),
    motion="sliding",
    ball_impact="mathavan2014",
    ball_friction=0.06,
    ball_restitution=0.9,
)


def names(*scenes):
    return [needed.name for needed in kernels_of(scenes)]


def test_scenes_that_need_the_same_kernel_name_it_once():
    assert names(ONE, TWO, INTEGRATED) == ["shots"]
    assert names(IN_AIR, ONE, IN_AIR) == ["shots in air and in flight", "shots"]


BEYOND = {"table": crowded_table()}
"""A scene that our engine doesn't support."""


def test_a_scene_that_is_not_played_needs_nothing():
    flies = scene_of(ball((0.2, 0.1), (1.0, 0.0)), **BEYOND)
    assert kernels_of([flies, "no scene"]) == []


def test_a_scene_that_breaks_a_rule_needs_nothing():
    invalid = ONE.model_copy(update={"t_max": math.nan})
    assert kernels_of([invalid]) == []
    warm_up([invalid])


@pytest.mark.compiled
def test_what_is_warm_is_compiled():
    simulate(ONE)
    (needed,) = kernels_of([ONE])
    assert needed.is_made


def test_every_kernel_is_each_of_those_of_scenes():
    every = every_kernel()
    assert len({one.name for one in every}) == len(every) == 2
    some = kernels_of([ONE, TWO, INTEGRATED])
    assert {one.name for one in some} < {one.name for one in every}
    assert every[0].name == "shots in air and in flight"
