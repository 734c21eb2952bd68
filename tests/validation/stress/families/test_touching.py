"""Touching starts: contacts are closed to the bit, and racks are their own mirror images."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from stress_trials import scene_trial, trials_of

from ghostball.engine import simulate
from ghostball.validation.stress.families.touching import (
    EVENTS_PER_BALL,
    FAMILY,
    RADIUS,
    STEPS_PER_BALL,
    images_of,
    triangle,
)


@pytest.mark.parametrize("gap", ["0", "1e-15", "1e-09"])
def test_a_gap_on_an_axis_is_what_it_says(gap):
    a, b = scene_trial(FAMILY, f"pair-elastic-into-gap-{gap}-turned-0.0").scene.balls
    opened = Fraction(b.position[0]) - Fraction(a.position[0]) - 2 * Fraction(RADIUS)
    assert abs(opened - Fraction(float(gap))) <= Fraction(2) ** -57  # an ulp of the place
    assert (opened == 0) == (gap == "0")


def test_a_triangle_is_its_own_image():
    places = triangle(15, 1e-9)
    assert len(places) == 120
    order = images_of(places)
    assert [order[k] for k in order] == list(range(120))
    assert np.hypot(*np.subtract(places[1], places[0])) >= 2 * RADIUS


def test_a_corner_that_gives_one_cushion_only_is_seen():
    trial = scene_trial(FAMILY, "bisector-to-0-0-from-2e-01")
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
    trial = scene_trial(FAMILY, name)
    run = simulate(trial.scene, record="trajectory")
    assert trial.judge(run).faults == ()
    state = run.final_state
    for field, by in (("positions", 1e-14), ("velocities", 1e-13)):
        off = replace(run, final_state=state._replace(**{field: getattr(state, field) + by}))
        assert trial.judge(off).faults
    fewer = replace(run, collision_counts={"ball-ball": 0, "ball-cushion": 0})
    assert "instead of" in trial.judge(fewer).faults[0]


def test_a_ball_that_leaves_a_corner_by_one_cushion_alone_is_seen():
    trial = scene_trial(FAMILY, "corner-sliding-slanting-gap-0")
    assert trial.judge(simulate(trial.scene, record="trajectory")).faults == ()
    table = trial.scene.table.model_copy(update={"cushions": ("left",)})
    half = trial.scene.model_copy(update={"table": table})
    run = replace(simulate(half, record="trajectory"), scene=trial.scene)
    assert "overlap" in trial.judge(run).faults[0]


@pytest.mark.compiled
def test_what_rows_racks_and_wedges_need_is_a_third_of_what_they_may():
    """Of all of the full suite: a limit that is far above says little."""
    events, steps = [], []
    for name, trial in trials_of(FAMILY, "full").items():
        if name.startswith(("line-", "triangle-", "wedged-")):
            run = simulate(trial.scene)
            events.append(run.work["events"] / len(trial.scene.balls))
            steps.append(run.work["contact_steps"] / len(trial.scene.balls))
            assert "elastic" not in name or steps[-1] == 0
    assert 0.25 * EVENTS_PER_BALL < max(events) <= EVENTS_PER_BALL / 3
    assert 0.25 * STEPS_PER_BALL < max(steps) <= STEPS_PER_BALL / 3


def test_a_row_that_takes_too_many_events_or_steps_is_seen():
    trial = scene_trial(FAMILY, "line-of-5-sliding-gap-0")
    run = simulate(trial.scene, record="trajectory")
    storm = replace(run, events=np.repeat(run.events, 36))
    assert any("number of events" in fault for fault in trial.judge(storm).faults)
    storm = replace(run, work={**run.work, "contact_steps": 6 * 51 + 1})
    assert any("contact steps" in fault for fault in trial.judge(storm).faults)
