"""Sustained contact: the shots press, symmetric ones are so to the bit, and storms are seen."""

from __future__ import annotations

from dataclasses import replace

from stress_trials import scene_trial, trials_of

from ghostball.engine import simulate
from ghostball.reference_adapters import make_engine
from ghostball.validation.stress.families.sustained import FAMILY
from ghostball.validation.stress.sound import Sound
from ghostball.validation.stress.trial import SceneTrial


def test_what_counts_as_symmetric_is_so():
    for trial in trials_of(FAMILY, "quick").values():
        assert isinstance(trial, SceneTrial)
        assert isinstance(trial.judge, Sound)
        if trial.judge.images and not trial.judge.swapped:
            for ball in trial.scene.balls:
                assert ball.position[1] == ball.velocity[1] == 0.0
                assert ball.angular_velocity is None or ball.angular_velocity[0] == 0.0


def test_a_storm_of_contact_steps_is_seen():
    trial = scene_trial(FAMILY, "follow-4-offset-0-restitution-0.5")
    run = simulate(trial.scene, record="trajectory")
    storm = replace(run, work={**run.work, "contact_steps": 1_000_000})
    assert len(trial.judge(storm).faults) == 1


def test_an_engine_that_lands_on_far_too_many_contacts_is_stopped():
    trial = scene_trial(FAMILY, "squeezed-2-offset-0.3-restitution-0.5-away-0", "quick")
    (fault,) = trial.run(make_engine("pymunk:contact_steps=exact")).faults
    assert "max_steps" in fault


def test_steps_of_its_own_length_are_not_bounded():
    # Breaks where events alone bound them: 5000 steps are eight times what these would allow.
    trial = scene_trial(FAMILY, "cushion-away-0-angle-0.5-restitution-0.5-speed-0")
    verdict = trial.run(make_engine("pymunk:dt=1e-4"))
    assert not any("max_steps" in fault for fault in verdict.faults)
