"""Relations: the second shot is right, an exact engine keeps them, a wrong engine is detected."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from right_shots import stress_shots

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Scene, Table
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.checks.criteria import relation_criteria
from ghostball.validation.checks.metrics import measure
from ghostball.validation.checks.related_shots import mirror
from ghostball.validation.checks.relations import (
    RELATIONS,
    RETURN_DISTANCE,
    rounding_of_way_back,
    scene_from_end,
)
from ghostball.validation.grading.tolerances import ROUNDINGS
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.stress import StressSize
from ghostball.validation.stress.gas import gas
from ghostball.validation.truth.scene_truth import Truth

OURS = make_engine("ghostball")


class Leaning(type(OURS)):
    """An engine that simulates every shot in a wind along x."""

    def simulate(self, scene, *, record="rest"):
        result = super().simulate(scene, record=record)
        end = result.final_state
        blown = end._replace(positions=end.positions + np.array([1e-6, 0.0, 0.0]))
        return replace(result, final_state=blown)


def related(name: str, scene: Scene, engine=OURS):
    """Return the value of a relation's metric, and the note if it has none."""
    result = engine.simulate(scene, record="trajectory")
    found = measure(result, Truth(None), {name}, engine=engine)
    return found.values[name], found.notes.get(name, "")


def test_the_mirrored_scene_has_left_and_bottom_swapped_and_is_its_own_inverse():
    scene = Scene(
        name="shot",
        table=Table(length=2.0, width=1.0, cushions=("left", "top")),
        physics=Physics(preset="pool"),
        balls=[
            Ball(
                id="a", position=(0.5, 0.3), velocity=(1.0, 2.0), angular_velocity=(3.0, 4.0, 5.0)
            ),
            Ball(id="b", position=(0.7, 0.6)),
        ],
    )
    other = mirror(simulate(scene, record="trajectory")).scene
    assert (other.table.length, other.table.width) == (1.0, 2.0)
    assert set(other.table.cushions) == {"bottom", "right"}
    assert [ball.id for ball in other.balls] == ["a", "b"]
    assert other.balls[0].position[:2] == (0.3, 0.5)
    assert other.balls[0].angular_velocity == (-4.0, -3.0, -5.0)
    assert mirror(simulate(other, record="trajectory")).scene.balls == scene.balls


@pytest.mark.parametrize("scene", ["draw-shot", "masse", "throw-slip", "english-running"])
def test_an_exact_engine_keeps_the_mirror_image_to_the_bit(scene: str):
    """Fails if the cloth, a ball or a cushion turns a ball the wrong way about one axis."""
    assert related("mirror_error", find_scene(scene)) == (0.0, "")


def test_an_engine_that_knows_left_from_right_is_seen():
    assert related("mirror_error", find_scene("half-ball-cut"), Leaning(OURS.settings))[0] > 1e-6


@pytest.mark.parametrize("after", [0.25, 0.75])
def test_an_exact_engine_comes_back_and_another_does_not(after: float):
    scene = gas(3, 0.2, after)
    factor, _ = related("reversal_factor", scene)
    assert 0.0 < factor < ROUNDINGS
    assert related("reversal_error", scene)[0] < RETURN_DISTANCE * scene.radii.min()
    assert related("reversal_error", scene, Leaning(OURS.settings))[0] > 1e-6


def test_nothing_is_asked_of_a_way_back_on_which_rounding_loses_the_way():
    value, why = related("reversal_error", gas(3, 0.2, 2.0))
    assert value is None
    assert "rounding alone keeps the reversed shot" in why


@pytest.mark.parametrize("relation", ["reversal_error", "reversal_factor"])
@pytest.mark.parametrize("friction", [0.0, 0.02])
def test_nothing_is_asked_of_a_way_back_without_the_energy_lost(
    relation: str, friction: float
) -> None:
    shot = Scene(
        name="cut",
        t_max=0.5,
        physics=Physics(rolling_friction=friction),
        balls=[
            Ball(id="a", position=(0.0, 0.0), velocity=(1.0, 0.0)),
            Ball(id="b", position=(0.3, 0.03)),
        ],
    )
    value, why = related(relation, shot)
    assert (value is None) == ("energy is lost" in why) == (friction > 0.0)


@pytest.mark.slow
@pytest.mark.compiled
def test_our_engine_is_lost_where_the_tangent_map_says():
    scene, lost, predicted = gas(3, 0.2, 4.0), [], []
    for turn in np.arange(0.25, 4.0, 0.125):
        there = simulate(scene.model_copy(update={"t_max": float(turn)}))
        back = simulate(scene_from_end(there, float(turn), -1.0))
        off = np.linalg.norm(back.rest_positions - scene.positions, axis=1).max()
        lost.append(off > RETURN_DISTANCE * scene.radii.min())
        predicted.append(
            rounding_of_way_back(scene, float(turn)) > RETURN_DISTANCE * scene.radii.min()
        )
    first, expected = 2 + np.argmax(lost), 2 + np.argmax(predicted)
    assert any(lost)
    assert expected / 1.5 <= first <= 1.5 * expected


def test_an_engine_that_leaves_balls_where_no_shot_begins_fails():
    shot = Scene(
        name="two",
        t_max=0.5,
        physics=Physics(rolling_friction=0.0),
        balls=[
            Ball(id="a", position=(0.0, 0.0), velocity=(1.0, 0.0)),
            Ball(id="b", position=(0.3, 0.0)),
        ],
    )

    class Together(type(OURS)):
        def simulate(self, scene, *, record="rest"):
            result = super().simulate(scene, record=record)
            end = result.final_state
            together = end.positions * np.array([0.0, 0.0, 1.0])
            return replace(result, final_state=end._replace(positions=together))

    engine = Together(OURS.settings)
    result = engine.simulate(shot, record="trajectory")
    found = measure(result, Truth(None), {"reversal_error"}, engine=engine)
    assert "reversal_error" in found.incomplete
    assert "isn't a valid initial state" in found.notes["reversal_error"]


def test_every_relation_is_asked_by_some_family():
    asked = {
        one.metric
        for _, shot in stress_shots(StressSize(count=1))
        for one in shot.criteria.criteria
    }
    on_request = {one.metric for one in relation_criteria().criteria}
    assert set(RELATIONS) - on_request <= asked
