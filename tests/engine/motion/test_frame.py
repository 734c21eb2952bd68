"""Tests of the frame of a table with pockets: skipping obstacles changes no bit."""

from __future__ import annotations

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.engine.running.skips import explain_skips
from ghostball.model import Scene, event_dict
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.scenes.random_scenes import PROVABLE, random_scene

POCKETS = ("pocket-bank", "pocket-break-9", "pocket-draw", "pocket-rattle", "pocket-side")


@pytest.mark.parametrize("scene", [*map(find_scene, POCKETS)], ids=lambda scene: scene.name)
def test_shots_into_pockets_agree_with_checking_all_obstacles(scene):
    kept, asked = (
        simulate(scene, record="trajectory", no_skip=off) for off in ((), ("far-obstacles",))
    )
    assert np.array_equal(kept.events, asked.events)
    assert kept.final_state.positions.tobytes() == asked.final_state.positions.tobytes()
    assert kept.work["events"] == asked.work["events"]


@pytest.mark.parametrize("seed", range(40))
def test_random_tables_with_pockets_agree_with_checking_all_obstacles(seed: int):
    scene = random_scene(seed, **{**PROVABLE, "table": "pockets", "flight": "no"})
    kept, asked = (
        simulate(scene, record="trajectory", no_skip=off) for off in ((), ("far-obstacles",))
    )
    assert np.array_equal(kept.events, asked.events)
    assert kept.final_state.positions.tobytes() == asked.final_state.positions.tobytes()


def test_a_hole_in_front_of_the_noses_takes_a_ball_that_stops_there():
    """The centre of the ball is in the hole, but the ball touches no nose."""
    corner = {"mouth": 0.13, "angle": 2.4, "jaw_radius": 0.01, "depth": 0.0, "radius": 0.08}
    scene = Scene.model_validate(
        {
            "name": "stops",
            "table": {"length": 2.54, "width": 1.27, "pockets": {"corner": corner}},
            "physics": {"rolling_friction": 0.01},
            # Without the hole, the ball would stop at (0.036, 0.045) m, 0.07 m from the centre of
            # the hole.
            "balls": [{"id": "a", "position": (1.0, 0.045), "velocity": (-0.43490, 0.0)}],
        }
    )
    result = simulate(scene, record="events")
    assert [event_dict(event)["kind"] for event in result.events] == ["pocketed"]
    used = {use.skip: use for use in explain_skips(scene)}["far-obstacles"]
    assert (used.used, used.why) == (False, "a hole reaches into the area without noses")


def test_only_a_table_with_pockets_has_a_frame():
    used = {
        name: {use.skip: use for use in explain_skips(find_scene(name))}["far-obstacles"].used
        for name in ("pocket-side", "break-16", "stop")
    }
    assert used == {"pocket-side": True, "break-16": False, "stop": False}
