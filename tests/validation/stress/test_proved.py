"""The judge of a run against its proof: a wrong run is seen, and a proof that says nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import Ball, GhostballError, Physics, Result, Scene
from ghostball.reference_adapters.certified import CertifiedSettings
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.checks import proof_metrics
from ghostball.validation.grading.grading import grade
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.stress.families import touching
from ghostball.validation.stress.families.extremes import ICE, cut
from ghostball.validation.stress.proved import (
    MatchesProof,
    ProvedTrial,
)

R = 2.0**-5


@pytest.fixture
def run() -> Result:
    return simulate(
        Scene(
            name="pair",
            physics=Physics(rolling_friction=0.0),
            t_max=1.0,
            balls=[
                Ball(id="a", radius=R, position=(0.0, 0.0), velocity=(1.0, 0.0)),
                Ball(id="b", radius=R, position=(0.5, 0.0)),
            ],
        ),
        record="trajectory",
    )


def test_our_engine_keeps_to_the_proof_and_another_shot_does_not() -> None:
    scene = find_scene("half-ball-cut")
    verdict = MatchesProof()(simulate(scene, record="trajectory"))
    assert verdict.faults == ()
    assert verdict.values["events"] == 3
    assert 0.0 < verdict.severity < 1.0
    # The same shot, played with a restitution that is off by a part in a million.
    physics = scene.physics.model_copy(update={"ball_restitution": 1.0 - 1e-6})
    wrong = simulate(scene.model_copy(update={"physics": physics}), record="trajectory")
    verdict = MatchesProof()(replace(wrong, scene=scene))
    assert any("quality_factor" in fault for fault in verdict.faults)
    assert verdict.severity >= 1.0


def test_an_event_that_is_not_proved_is_seen(run):
    # A run whose only collision was passed over, and the balls went through each other.
    none = run.events[:0]
    (first, *_) = MatchesProof()(replace(run, events=none)).faults
    assert "events_missing" in first
    assert (
        "events_invented" in MatchesProof()(replace(run, events=np.repeat(run.events, 2))).faults[0]
    )


def test_an_end_that_is_not_proved_is_seen(run):
    off = run.final_state.positions.copy()
    off[0, 0, 0] += 1e-12
    exact = replace(run, final_state=run.final_state._replace(positions=off))
    assert any("quality_factor" in fault for fault in MatchesProof()(exact).faults)


def test_events_and_an_end_that_come_late_are_seen(run):
    # Neither moves a ball: an event by a nanosecond, the end by as much.
    events = run.events.copy()
    events["t"] += 1e-9
    late = MatchesProof()(replace(run, events=events)).faults
    assert late[0].startswith("event_time_factor is ")
    ends = MatchesProof()(replace(run, rest_time=run.rest_time + 1e-9)).faults
    assert ends[0].startswith("rest_time_factor is ")


def test_a_right_run_survives_and_is_graded_once(run, monkeypatch):
    grades = []

    def counted(*arguments):
        grades.append(grade(*arguments))
        return grades[-1]

    monkeypatch.setattr(proof_metrics, "grade", counted)
    assert MatchesProof()(run).faults == ()
    assert len(grades) == 1


def test_an_engine_that_steps_is_asked_what_its_step_allows():
    shot = cut("cut", ICE)
    fine, coarse = make_engine("pymunk:dt=1e-4"), make_engine("pymunk:dt=1e-3")
    trial = ProvedTrial("cut", shot)
    assert trial.run(coarse).faults == trial.run(fine).faults == ()

    class Claiming(type(coarse)):
        """Steps as coarsely, and says that it is as fine."""

        def resolution(self, scene):
            return fine.resolution(scene)

    faults = trial.run(Claiming(coarse.settings)).faults
    for metric in ("rest_error_max", "event_time_error"):
        assert any(f"{metric} must be <=" in fault for fault in faults)


def test_a_ball_that_nothing_moves_must_stay():
    still = Scene(name="still", t_max=1.0, balls=[Ball(id="a", radius=R, position=(0.25, 0.0))])
    right = simulate(still, record="trajectory")
    assert MatchesProof()(right).faults == ()
    off = right.final_state.positions + np.array([2.0**-60, 0.0, 0.0])
    off[0, 0, 0] = 0.25 + 64.0 * np.spacing(0.25)  # one rounding is allowed
    crept = replace(right, final_state=right.final_state._replace(positions=off))
    assert MatchesProof()(crept).faults


def test_a_proof_that_says_nothing_is_no_pass():
    """A ball that stops by symmetry: nothing is proved, and so nothing would be judged."""
    name = "wedged-corner-elastic-gap-0"
    (scene,) = (one.scene for one in touching.FAMILY.trials("quick") if one.name == name)
    with pytest.raises(GhostballError, match="nothing is proved of scene"):
        MatchesProof()(simulate(scene, record="trajectory"))
    with pytest.raises(GhostballError, match="nothing is proved of scene"):
        ProvedTrial(name, scene).run(make_engine("ghostball"))


def test_a_proof_that_ends_before_it_must_fails_whatever_the_run() -> None:
    # Breaks where a proof of one event counts as much as one of all.
    scene = find_scene("half-ball-cut")
    result = simulate(scene, record="trajectory")
    gave_up = CertifiedSettings(max_events=1)
    verdict = MatchesProof(settings=gave_up)(result)
    assert "only 1 events of scene 'half-ball-cut' are proved, all to its end" in str(verdict)
    assert MatchesProof(settings=gave_up, least=1)(result).faults == ()
    (fault,) = MatchesProof(settings=gave_up, least=2)(result).faults
    assert ", 2 must be: event limit" in fault
    assert MatchesProof(least=7)(result).faults == ()  # all of its three are proved
