"""What every shipped scene costs the engine, as exact counts: the same on every machine.

A count that rises is a regression, whatever a clock says; one that falls is to be kept. Store the
new ones with `python tests/validation/test_work.py`, and say in the changelog what changed.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from engine import simulate
from validation.bench import many_balls
from validation.library import find_scene, scene_names

STORE = Path(__file__).with_name("work.json")


CROWDS = {scene.name: scene for scene in many_balls()}
"""Scenes that cells schedule: the shipped ones have too few balls."""
NAMES = sorted([*scene_names(), *CROWDS])


def work_of(name: str) -> dict[str, int]:
    return dict(simulate(CROWDS.get(name) or find_scene(name)).work)


def test_every_scene_has_its_counts_and_none_is_left_over():
    assert sorted(json.loads(STORE.read_text())) == NAMES


@pytest.mark.compiled
@pytest.mark.parametrize("name", NAMES)
def test_no_count_moves(name):
    stored = json.loads(STORE.read_text())[name]
    moved = {
        counter: f"{stored.get(counter)} -> {count}"
        for counter, count in work_of(name).items()
        if count != stored.get(counter)
    }
    assert not moved, f"the work for {name} changed: {moved}"


if __name__ == "__main__":
    counts = {name: work_of(name) for name in NAMES}
    STORE.write_text(json.dumps(counts, indent=1) + "\n")
