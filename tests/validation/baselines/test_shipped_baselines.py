"""The accepted baselines hold: the bits of every shipped shot, and what it costs as exact counts.

A hash that changes means that numbers moved, a count that rises is a regression, whatever a clock
says. `ghostball regress` says what moved and by how much, `ghostball accept` takes it, with why.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from ghostball.engine import simulate
from ghostball.validation.baselines import load_baseline
from ghostball.validation.baselines.baseline import baseline_names, baseline_path
from ghostball.validation.baselines.gate import crowds
from ghostball.validation.baselines.observed import Observed
from ghostball.validation.results.records import scene_hash
from ghostball.validation.scenes.library import find_scene, scene_names

OURS = Path(__file__).parents[3] / "benchmarks/baselines/ghostball"
CROWDS = {scene.name: scene for scene in crowds()}
"""Scenes that cells schedule: the shipped ones have too few balls."""
SCENES = sorted([*scene_names(), *CROWDS])


def scene_of(name: str):
    return CROWDS.get(name) or find_scene(name)


def test_every_scene_has_a_baseline_and_none_is_left_over():
    assert list(baseline_names(OURS)) == SCENES


@pytest.mark.parametrize("name", SCENES)
def test_a_baseline_is_of_the_scene_as_it_is(name):
    # Else `regress` compares nothing there, and says so.
    baseline = load_baseline(baseline_path(OURS, name))
    assert baseline.scene_hash == scene_hash(scene_of(name))
    assert baseline.hash.level == "error"
    assert {one.level for one in baseline.work.values()} == {"error"}


@pytest.mark.compiled
@pytest.mark.parametrize("name", SCENES)
def test_no_bit_and_no_count_moves(name):
    baseline = load_baseline(baseline_path(OURS, name))
    found = Observed.of_result(simulate(scene_of(name), record="events"))
    assert found.work == baseline.observed.work, "the work changed: `ghostball regress` says how"
    assert found.bits == baseline.hash.bits, "bits moved: `ghostball regress` says how far"
    assert found.sequence == baseline.hash.sequence
