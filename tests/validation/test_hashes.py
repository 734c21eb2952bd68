"""One stored hash per shipped scene: the engine's event log and rest positions, to the bit.

A hash that changes means that numbers moved: say so in the changelog under "Results change", and
store the new ones with `python tests/validation/test_hashes.py`.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))
from invariants import fingerprint

from engine import simulate
from validation.bench import many_balls
from validation.library import find_scene, scene_names

STORE = Path(__file__).with_name("hashes.json")
CROWDS = {scene.name: scene for scene in many_balls()}
"""Scenes that cells schedule: the shipped ones have too few balls."""
SCENES = sorted([*scene_names(), *CROWDS])


def hash_of(name: str) -> str:
    return fingerprint(simulate(CROWDS.get(name) or find_scene(name), record="events"))


def test_every_scene_has_a_hash_and_no_hash_is_left_over():
    assert sorted(json.loads(STORE.read_text())) == SCENES


@pytest.mark.compiled
@pytest.mark.parametrize("name", SCENES)
def test_the_stored_hash_holds(name):
    assert hash_of(name) == json.loads(STORE.read_text())[name]


if __name__ == "__main__":
    hashes = {name: hash_of(name) for name in SCENES}
    STORE.write_text(json.dumps(hashes, indent=1) + "\n")
