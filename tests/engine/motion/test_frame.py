"""The frame of a table with pockets: what it leaves out changes no bit."""

from __future__ import annotations

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.engine.running.skips import explain_skips
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.scenes.random_scenes import PROVABLE, random_scene

POCKETS = ("pocket-bank", "pocket-break-9", "pocket-draw", "pocket-rattle", "pocket-side")


@pytest.mark.parametrize("scene", [*map(find_scene, POCKETS)], ids=lambda scene: scene.name)
def test_shots_into_pockets_are_the_same_where_all_obstacles_are_asked(scene):
    kept, asked = (
        simulate(scene, record="trajectory", no_skip=off) for off in ((), ("far-obstacles",))
    )
    assert np.array_equal(kept.events, asked.events)
    assert kept.final_state.positions.tobytes() == asked.final_state.positions.tobytes()
    assert kept.work["events"] == asked.work["events"]


@pytest.mark.parametrize("seed", range(40))
def test_random_tables_with_pockets_are_the_same_where_all_obstacles_are_asked(seed: int):
    scene = random_scene(seed, **{**PROVABLE, "table": "pockets", "flight": "no"})
    kept, asked = (
        simulate(scene, record="trajectory", no_skip=off) for off in ((), ("far-obstacles",))
    )
    assert np.array_equal(kept.events, asked.events)
    assert kept.final_state.positions.tobytes() == asked.final_state.positions.tobytes()


def test_only_a_table_with_pockets_has_a_frame():
    used = {
        name: {use.skip: use for use in explain_skips(find_scene(name))}["far-obstacles"].used
        for name in ("pocket-side", "break-16", "stop")
    }
    assert used == {"pocket-side": True, "break-16": False, "stop": False}
