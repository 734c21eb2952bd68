"""Shots against their proofs: right ones survive, wrong ones don't."""

from __future__ import annotations

import pytest

from ghostball.engine import simulate
from ghostball.model import Scene
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.scenes.random_shots import random_shot
from ghostball.validation.stress.families.graded import (
    BATCH,
    CALM,
    CalmShots,
    ProvedShots,
    many_balls,
)

OURS = make_engine("ghostball")


def test_random_shots_are_counted_and_the_worst_is_shown() -> None:
    verdict = CalmShots("few", 10, 4).run(OURS)
    assert (verdict.faults, verdict.shots, verdict.broken) == ((), 4, 0)
    cut_short = ProvedShots("few", 10, 4).run(make_engine("ghostball:max_events=1"))
    assert cut_short.shots == 4
    assert 0 < cut_short.broken <= 4
    assert cut_short.scene is not None
    assert any(fault.startswith(cut_short.scene.name) for fault in cut_short.faults)


@pytest.mark.slow
def test_calm_shots_have_no_long_contact() -> None:
    for number in CALM:
        assert simulate(random_shot(number)).work["contact_steps"] < 500
    assert len(CALM) % BATCH == 0


def test_many_balls_meet() -> None:
    scene: Scene = many_balls("many-balls", find_scene("stop").physics, 0)
    result = simulate(scene, record="events")
    assert len(scene.balls) > 100
    assert result.collision_counts["ball-ball"] > 10
    assert result.work["cell_moves"] > 10
