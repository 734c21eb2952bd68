"""Jaws, holes and corners: the depths and the counts are right, and a wrong answer is seen."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from stress_trials import trials_of

from ghostball.engine import simulate
from ghostball.model import EventKind
from ghostball.reference_adapters.certified import certify
from ghostball.validation.stress.families.pockets import FAMILY, Meets, wedge
from ghostball.validation.stress.trial import SceneTrial

TRIALS = trials_of(FAMILY, "quick")


@pytest.mark.parametrize("degrees", [90.5, 31.0, 7.0, 1.0])
def test_a_proof_says_how_often_a_ball_bounces_in_a_corner(degrees: float):
    scene, count = wedge("wedge", math.radians(degrees))
    certificate = certify(scene, cached=False)
    assert certificate.proved
    assert len(certificate.events) == count


def test_a_ball_that_falls_and_must_not_is_seen():
    trial = TRIALS["falling-1e-03"]
    assert isinstance(trial, SceneTrial)
    result = simulate(trial.scene, record="events")
    assert not trial.judge(result).faults
    (fault,) = Meets(EventKind.POCKETED, 0)(result).faults
    assert fault == "1 events pocketed, where there must be 0"
    assert result.events is not None
    assert trial.judge(replace(result, events=result.events[:0])).faults
