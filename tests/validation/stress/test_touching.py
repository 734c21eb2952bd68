"""Touching starts: contacts are closed to the bit, and racks are their own mirror images."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from engine import simulate
from validation.stress.families.touching import FAMILY, R, images_of, triangle
from validation.stress.trial import SceneTrial

TRIALS = {trial.name: trial for trial in FAMILY.trials("full")}


def trial_of(name: str) -> SceneTrial:
    trial = TRIALS[name]
    assert isinstance(trial, SceneTrial)
    return trial


def test_names_are_unique_and_the_full_suite_has_every_number_and_gap():
    names = [trial.name for trial in FAMILY.trials("full")]
    assert len(names) == len(set(names))
    assert {f"line-of-{n}-sliding-gap-0" for n in range(2, 16)} < set(names)
    assert {f"triangle-of-{n}-rows-rolling-gap-0" for n in range(3, 16)} < set(names)
    assert {f"corner-elastic-into-gap-1e-{k:02d}" for k in range(3, 16)} < set(names)


@pytest.mark.parametrize("gap", ["0", "1e-15", "1e-09"])
def test_a_gap_on_an_axis_is_what_it_says(gap):
    a, b = trial_of(f"pair-elastic-into-gap-{gap}-turned-0.0").scene.balls
    opened = Fraction(b.position[0]) - Fraction(a.position[0]) - 2 * Fraction(R)
    assert abs(opened - Fraction(float(gap))) <= Fraction(2) ** -57  # an ulp of the place
    assert (opened == 0) == (gap == "0")


def test_a_triangle_is_its_own_image():
    places = triangle(15, 1e-9)
    assert len(places) == 120
    order = images_of(places)
    assert [order[k] for k in order] == list(range(120))
    assert np.hypot(*np.subtract(places[1], places[0])) >= 2 * R


@pytest.mark.parametrize(
    "name",
    [
        "pair-sliding-slanting-gap-0-turned-0.7",
        "corner-rolling-slanting-gap-0",
        "bisector-to-1-0-from-2e-01",
        "line-of-5-sliding-gap-0",
        "triangle-of-3-rows-sliding-gap-0",
        "wedged-pair-pushed-sliding-gap-0",
        "wedged-corner-sliding-gap-0",
    ],
)
def test_our_engine_survives(name):
    trial = trial_of(name)
    run = simulate(trial.scene, record="trajectory")
    assert trial.judge(run).faults == ()


def test_a_corner_that_gives_one_cushion_only_is_seen():
    trial = trial_of("bisector-to-0-0-from-2e-01")
    half = trial.scene.model_copy(
        update={"table": trial.scene.table.model_copy(update={"cushions": ("left",)})}
    )
    assert trial.judge(simulate(half, record="trajectory")).faults


@pytest.mark.parametrize(
    "name",
    [
        "pair-elastic-into-gap-0-turned-0.7",
        "pair-elastic-into-gap-0-turned-4.0",
        "corner-elastic-slanting-gap-0",
        "corner-rolling-slanting-gap-0",
    ],
)
def test_where_no_proof_says_anything_a_closed_form_does(name):
    trial = trial_of(name)
    run = simulate(trial.scene, record="trajectory")
    assert trial.judge(run).faults == ()
    state = run.final_state
    for field, by in (("positions", 1e-14), ("velocities", 1e-13)):
        off = replace(run, final_state=state._replace(**{field: getattr(state, field) + by}))
        assert trial.judge(off).faults
    fewer = replace(run, collision_counts={"ball-ball": 0, "ball-cushion": 0})
    assert "instead of" in trial.judge(fewer).faults[0]


def test_a_ball_that_leaves_a_corner_by_one_cushion_alone_is_seen():
    trial = trial_of("corner-sliding-slanting-gap-0")
    assert trial.judge(simulate(trial.scene, record="trajectory")).faults == ()
    table = trial.scene.table.model_copy(update={"cushions": ("left",)})
    half = trial.scene.model_copy(update={"table": table})
    run = replace(simulate(half, record="trajectory"), scene=trial.scene)
    assert "overlap" in trial.judge(run).faults[0]
