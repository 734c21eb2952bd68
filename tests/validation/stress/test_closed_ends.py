"""Closed ends: shots end as their closed forms say, and other ends are seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ghostball.engine import simulate
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.stress.closed_ends import ClosedEnd, parted_end, parting, shipped_end
from ghostball.validation.stress.families.graded import FAMILY
from ghostball.validation.stress.trial import SceneTrial


def trials() -> dict[str, SceneTrial]:
    return {one.name: one for one in FAMILY.trials("quick") if isinstance(one, SceneTrial)}


def test_ends_are_those_of_closed_forms_and_others_are_caught() -> None:
    ends = {name: one for name, one in trials().items() if isinstance(one.judge, ClosedEnd)}
    some = ("corner-exact", "three-ball-symmetric", "push", "wedged", "parting")
    assert {f"{name}-end" for name in some} <= set(ends)
    for name, one in ends.items():
        result = simulate(one.scene, record="trajectory")
        assert one.judge(result).faults == (), name
        late = replace(result, rest_time=result.rest_time + 1e-4)
        assert "the end is" in one.judge(late).faults[0]
        more = replace(result, collision_counts={"ball-ball": 7, "ball-cushion": 0})
        assert "instead of" in one.judge(more).faults[0]
        moved = result.final_state.positions + 1e-4
        off = replace(result, final_state=result.final_state._replace(positions=moved))
        assert "a ball ends" in one.judge(off).faults[0]


def test_a_pushed_ball_parts_where_the_other_is_slowed_more() -> None:
    scene = parting()
    places = parted_end(scene).places
    assert places[1][0] - places[0][0] > 3.0 * 2.0 * scene.balls[0].radius
    alike = scene.model_copy(update={"balls": find_scene("push").balls})
    assert np.allclose(parted_end(alike).places, shipped_end(find_scene("push")).places, rtol=1e-12)
