"""Shots against their proofs, and impacts at one instant: right ones survive, wrong ones don't."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from engine import Scene, simulate
from reference_adapters.registry import make_engine
from validation.library import find_scene
from validation.random_shots import random_shot
from validation.stress.families.graded import (
    BATCH,
    CALM,
    FAMILY,
    CalmShots,
    ClosedEnd,
    Proved,
    ProvedShots,
    Velocities,
    crowd,
    parted_end,
    parting,
    shipped_end,
)
from validation.stress.trial import SceneTrial

OURS = make_engine("ghostball")


def trials() -> dict[str, SceneTrial]:
    return {one.name: one for one in FAMILY.trials("quick") if isinstance(one, SceneTrial)}


def test_our_engine_keeps_to_the_proof_and_another_shot_does_not() -> None:
    scene = find_scene("half-ball-cut")
    verdict = Proved()(simulate(scene, record="trajectory"))
    assert verdict.faults == ()
    assert verdict.values["events"] == 3
    assert 0.0 < verdict.severity < 1.0
    # The same shot, played with a restitution that is off by a part in a million.
    physics = scene.physics.model_copy(update={"ball_restitution": 1.0 - 1e-6})
    wrong = simulate(scene.model_copy(update={"physics": physics}), record="trajectory")
    verdict = Proved()(replace(wrong, scene=scene))
    assert any("quality_factor" in fault for fault in verdict.faults)
    assert verdict.severity >= 1.0


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


def test_impacts_at_one_instant_come_out_as_their_closed_forms() -> None:
    ties = [one for name, one in trials().items() if name.startswith("tie-")]
    assert len(ties) == 8
    for tie in ties:
        assert tie.run(OURS).faults == (), tie.name


def test_the_expected_velocities_keep_momentum_and_lose_energy() -> None:
    for name, tie in trials().items():
        if not isinstance(tie.judge, Velocities):
            continue
        expected = np.array(tie.judge.velocities)
        assert np.allclose(expected.sum(axis=0), (1.0, 0.0), rtol=0.0, atol=1e-15), name
        energy = float(np.sum(expected**2))
        if name.endswith("-1"):
            assert math.isclose(energy, 1.0, rel_tol=1e-14), name
        else:
            assert energy < 1.0, name


@pytest.mark.parametrize(
    ("name", "other"),
    [
        ("tie-uneven-sequential-1", "tie-uneven-simultaneous-1"),
        ("tie-symmetric-simultaneous-0.5", "tie-symmetric-simultaneous-1"),
    ],
)
def test_another_resolution_of_a_tie_is_caught(name: str, other: str) -> None:
    found = trials()
    judge, wrong = found[name].judge, found[other].scene
    verdict = judge(simulate(wrong, record="trajectory"))
    assert verdict.faults
    assert "instead of" in verdict.faults[0]


def test_a_mirrored_tie_is_caught() -> None:
    tie = trials()["tie-symmetric-sequential-1"]
    swapped = replace(
        tie.judge,  # type: ignore[type-var]
        velocities=tuple((vx, -vy) for vx, vy in tie.judge.velocities),  # type: ignore[attr-defined]
    )
    assert tie.run(OURS).faults == ()
    assert replace(tie, judge=swapped).run(OURS).faults


def test_ends_are_those_of_closed_forms_and_others_are_caught() -> None:
    ends = {name: one for name, one in trials().items() if isinstance(one.judge, ClosedEnd)}
    assert {"corner-exact-end", "push-end", "wedged-end", "parting-end"} <= set(ends)
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


def test_a_crowd_is_of_many_balls_that_meet() -> None:
    scene: Scene = crowd("crowd", find_scene("stop").physics, 0)
    result = simulate(scene, record="events")
    assert len(scene.balls) > 100
    assert result.collision_counts["ball-ball"] > 10
    assert result.work["cell_moves"] > 10


def test_it_is_about_our_engine() -> None:
    assert FAMILY.ours_alone
