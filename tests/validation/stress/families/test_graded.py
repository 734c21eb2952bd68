"""Shots against their proofs: right ones survive, wrong ones don't."""

from __future__ import annotations

from dataclasses import replace

from stress_trials import scene_trial, trials_of

from ghostball.engine import simulate
from ghostball.reference_adapters.certified import CertifiedSettings
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.stress.families.graded import FAMILY
from ghostball.validation.stress.proved import MatchesProof

OURS = make_engine("ghostball")


SHOTS = trials_of(FAMILY, "quick")["shots-0010+10"]


def test_random_shots_are_counted_and_the_worst_is_shown() -> None:
    verdict = SHOTS.run(OURS)
    assert (verdict.faults, verdict.shots, verdict.broken) == ((), 10, 0)
    cut_short = SHOTS.run(make_engine("ghostball:max_events=1"))
    assert cut_short.shots == 10
    assert 0 < cut_short.broken <= 10
    assert cut_short.scene is not None
    assert any(fault.startswith(cut_short.scene.name) for fault in cut_short.faults)


def test_proofs_that_end_early_are_a_fault_of_all() -> None:
    gave_up = MatchesProof(CertifiedSettings(max_events=1), least=0)
    (fault,) = replace(SHOTS, judge=gave_up).run(OURS).faults
    assert "of these shots are proved to their ends, 5 must be" in fault


def test_many_balls_meet() -> None:
    scene = scene_trial(FAMILY, "many-balls-elastic-0", "quick").scene
    result = simulate(scene, record="events")
    assert result.collision_counts["ball-ball"] > 10
    assert result.work["cell_moves"] > 10
