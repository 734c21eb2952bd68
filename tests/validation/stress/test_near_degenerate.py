"""Near-degenerate motion: the proofs reach, and the exact cases are exact."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from stress_trials import trials_of

from ghostball.engine import simulate
from ghostball.reference_adapters.certified import certify
from ghostball.validation.stress.families.near_degenerate import FAMILY
from ghostball.validation.stress.proved import ProvedTrial
from ghostball.validation.stress.trial import SceneTrial


def is_pressed(name: str) -> bool:
    """Whether the balls meet so slowly that they stay together: the proof ends there."""
    by = name.removeprefix("rolling-slowed-more-by-").removesuffix("-met")
    return by in {f"1e-{power:02d}" for power in range(4, 14)}


def test_what_is_asked_is_proved_and_happens():
    endings, events = Counter(), Counter()
    for trial in trials_of(FAMILY, "quick").values():
        if isinstance(trial, ProvedTrial):
            certificate = certify(trial.scene)
            endings[certificate.ending] += 1
            events[len(certificate.events)] += 1
    assert set(endings) == {"proved"}
    assert events[1] >= 12  # they meet; what slows alike or turns away doesn't


@pytest.mark.parametrize("kind", ["elastic", "rolling", "sliding"])
def test_touching_balls_of_one_velocity_stay_together(kind):
    trial = trials_of(FAMILY, "quick")[f"{kind}-alike-gap-0-course-0.7"]
    assert isinstance(trial, SceneTrial)
    a, b = trial.scene.balls
    assert b.position[0] - a.position[0] == a.radius + b.radius
    assert a.velocity == b.velocity
    run = simulate(trial.scene, record="trajectory")
    assert trial.judge(run).faults == ()


def test_a_phantom_collision_of_such_balls_is_seen():
    trial = trials_of(FAMILY, "quick")["rolling-alike-gap-1e-03-course-0.0"]
    other = trials_of(FAMILY, "quick")["rolling-slower-by-1e-01-at-0-turned-0"]
    assert isinstance(trial, SceneTrial)
    assert isinstance(other, ProvedTrial)
    faults = trial.judge(simulate(other.scene, record="trajectory")).faults
    assert any("1 collisions instead of 0" in fault for fault in faults)


def test_balls_that_are_pressed_are_known_to_the_hop_that_is_left_out():
    pressed = [trial for name, trial in trials_of(FAMILY, "full").items() if is_pressed(name)]
    assert len(pressed) == 10
    for trial in pressed:
        run = simulate(trial.scene, record="trajectory")
        assert trial.judge(run).faults == (), trial.name


@pytest.mark.parametrize("power", ["04", "08"])
def test_a_pair_that_meets_unseen_is_seen(power):
    """The ball behind goes on as if it were alone."""
    trial = trials_of(FAMILY, "full")[f"rolling-slowed-more-by-1e-{power}-met"]
    alone = trial.scene.model_copy(update={"balls": trial.scene.balls[:1]})
    through = simulate(alone, record="trajectory").final_state
    run = simulate(trial.scene, record="trajectory")
    state = run.final_state._replace(
        positions=np.concatenate([through.positions, run.final_state.positions[:, 1:]], axis=1),
        velocities=np.concatenate([through.velocities, run.final_state.velocities[:, 1:]], axis=1),
    )
    faults = trial.judge.second(replace(run, final_state=state)).faults
    assert len(faults) == 2
    assert "velocity" in faults[0]
    assert "from where it must" in faults[1]
