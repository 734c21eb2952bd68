"""Random breaks in a row: all are played by ours, one by others, and the worst is shown."""

from __future__ import annotations

from dataclasses import replace

import pytest
from shots import kept_scene
from stress_trials import trials_of

from ghostball.engine import simulate
from ghostball.model import UnsupportedSceneError
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.stress.families import storms
from ghostball.validation.stress.families.storms import FOREIGN_T_MAX

BREAKS = next(iter(trials_of(storms.FAMILY, "quick").values()))


@pytest.mark.compiled
def test_our_engine_plays_all_and_the_one_that_came_nearest_is_shown():
    engine = make_engine("ghostball")
    verdict = replace(BREAKS, count=10).run(engine)
    assert (verdict.faults, verdict.shots, verdict.broken) == ((), 10, 0)
    alone = [replace(BREAKS, first=number, count=1).run(engine) for number in range(10)]
    worst = max(alone, key=lambda one: one.severity)
    assert (verdict.severity, verdict.scene) == (worst.severity, worst.scene)


@pytest.mark.compiled
def test_a_scene_that_does_not_end_is_a_fault():
    verdict = replace(BREAKS, count=10).run(make_engine("ghostball:max_events=20"))
    assert verdict.broken > 0
    assert "event limit" in verdict.faults[0]
    assert verdict.scene is not None


@pytest.mark.compiled
def test_the_longest_break_known_needs_an_eighth_of_what_is_allowed():
    work = simulate(kept_scene("break-of-most-events")).work  # number 944 of 6550 random ones
    needed = work["events"] + work["contact_steps"]
    assert 8 * needed <= storms.MOST < 9 * needed


def test_another_engine_plays_one_and_says_what_it_lacks(monkeypatch):
    verdict = BREAKS.run(make_engine("paper-continuous"))
    assert verdict.shots == 1
    assert verdict.scene is not None
    assert verdict.scene.t_max == FOREIGN_T_MAX
    monkeypatch.setattr(storms, "BREAKS", {**storms.BREAKS, "motion": "sliding"})
    with pytest.raises(UnsupportedSceneError) as caught:
        replace(BREAKS, count=1).run(make_engine("paper-continuous"))
    assert caught.value.features
