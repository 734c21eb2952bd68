"""Grazing: the depths are right, and a wrong answer is seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from stress_trials import trials_of

from ghostball.engine import simulate
from ghostball.model import EventKind
from ghostball.validation.stress.families.grazing import FAMILY, HitOrMiss
from ghostball.validation.stress.trial import SceneTrial

TRIALS = trials_of(FAMILY, "quick")
KINDS = ("rolling", "elastic", "sliding", "small", "curved", "cushion")


def judged(name: str) -> tuple[SceneTrial, HitOrMiss]:
    trial = TRIALS[name]
    assert isinstance(trial, SceneTrial)
    assert isinstance(trial.judge, HitOrMiss)
    return trial, trial.judge


@pytest.mark.parametrize("kind", KINDS)
def test_a_miss_a_phantom_and_a_double_collision_are_seen(kind: str):
    hit, miss = judged(f"{kind}-hit-1e-01"), judged(f"{kind}-miss-1e-01")
    runs = [simulate(trial.scene, record="events") for trial, _ in (hit, miss)]
    assert not hit[1](runs[0]).faults
    assert not miss[1](runs[1]).faults
    assert runs[0].events is not None
    without = runs[0].events[runs[0].events["kind"] != hit[1].kind]
    missed = hit[1](replace(runs[0], events=without))
    assert missed.faults == ("a collision 1.00e-01 diameters deep is missed",)
    assert missed.broken == 1
    assert missed.severity >= 1.0
    (phantom,) = miss[1](replace(runs[1], events=runs[0].events)).faults
    assert "a collision is seen where the path misses by 1.00e-01" in phantom
    twice = np.concatenate([runs[0].events, runs[0].events])
    assert hit[1](replace(runs[0], events=twice)).faults == ("2 collisions where there is one",)


def test_the_deepest_miss_and_else_the_shallowest_shot_is_the_worst_case():
    trial, _ = judged("rolling-hit-1e-01")
    run = simulate(trial.scene, record="events")
    assert run.events is not None
    lost = replace(run, events=run.events[run.events["kind"] != EventKind.BALL_BALL])
    deep, shallow = (HitOrMiss(10.0**-power) for power in (1, 13))
    assert deep(lost).severity > shallow(lost).severity >= 1.0
    assert deep(run).severity < shallow(run).severity < 1.0
