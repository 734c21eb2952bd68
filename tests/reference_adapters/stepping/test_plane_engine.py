"""Simple shots that every engine in the plane must simulate to the precision of its arithmetic."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import pytest
from engine_facts import FREE, cut_angles, frozen_line, head_on, needs, play, shares, to_the_wall
from shots import ball, scene_of

from ghostball.engine import simulate
from ghostball.model import EventKind
from ghostball.validation.scenes.library import find_scene

IN_JAVASCRIPT = ("planck", "matter-js", "cannon-es")


def of_each(facts: Mapping[str, Any]) -> list[Any]:
    """Return specs with their expected values; without their engine they are skipped."""
    return [
        pytest.param(spec, fact, marks=needs(spec.partition(":")[0]), id=spec)
        for spec, fact in facts.items()
    ]


class Exactness(NamedTuple):
    balls: float
    """Relative error of the speeds after a head-on collision."""
    wall: float
    """The same for a cushion contact at 45 degrees."""
    restitutions: tuple[float, ...] = (0.0, 0.5, 0.9, 1.0)
    walls: tuple[float, ...] = (0.0, 0.5, 0.9, 1.0)


COLLISIONS = {
    "box2d": Exactness(1e-6, 1e-6),
    "box2d:bullet=no": Exactness(1e-6, 1e-6),
    # The normal of a long edge in single precision; the larger of the two restitutions.
    "box2d3": Exactness(1e-5, 3e-5, walls=(1.0,)),
    # Overlapping balls are pushed apart, so no collision is completely inelastic.
    "dart": Exactness(3e-5, 3e-5, (0.5, 0.9, 1.0), (0.5, 0.9, 1.0)),
    "mujoco": Exactness(2e-9, 1e-12),
    "physx": Exactness(1e-6, 1e-6),
    "pybullet": Exactness(1e-12, 1e-12),
    "pymunk": Exactness(1e-12, 1e-12),
    "newton": Exactness(1e-6, 1e-6),
    "newton:solver=xpbd": Exactness(1e-6, 1e-6),
    "rapier": Exactness(1e-6, 1e-6),
    **dict.fromkeys(IN_JAVASCRIPT, Exactness(2e-6, 2e-6)),
}


@pytest.mark.parametrize("steps", ["fixed", "exact"])
@pytest.mark.parametrize(("name", "exactness"), of_each(COLLISIONS))
def test_a_single_collision_is_right_at_any_restitution(
    name: str, exactness: Exactness, steps: str
) -> None:
    """Factors, dampers and thresholds must result in the scene's restitution."""
    spec = f"{name}{',' if ':' in name else ':'}contact_steps={steps}"
    for e in exactness.restitutions:
        wanted = [(1.0 - e) / 2.0, (1.0 + e) / 2.0]
        assert shares(spec, head_on(restitution=e)) == pytest.approx(wanted, abs=exactness.balls)
    for e in exactness.walls:
        x, y = play(spec, to_the_wall(e)).final_state.velocities[0, 0, :2]
        assert (x, y) == pytest.approx((-e, 1.0), abs=exactness.wall)


@pytest.mark.parametrize(
    ("name", "tangential"),
    of_each(
        {"newton": 0.8, "pybullet": 1.0, "rapier": 1.0}
        | dict.fromkeys(("pymunk", *IN_JAVASCRIPT), 0.8)
    ),
)
def test_balls_and_cushions_have_restitutions_of_their_own(name: str, tangential: float) -> None:
    """The adapter must compensate the engine's own rule, such as the product of two factors."""
    cushion = {"cushion_restitution": 0.9, "cushion_tangential_restitution": tangential}
    own = {"ball_restitution": 0.5, "cushion": "restitution", **cushion}
    scene = to_the_wall().model_copy(update={"physics": FREE.model_copy(update=own)})
    velocity = play(name, scene).final_state.velocities[0, 0, :2]
    assert velocity == pytest.approx((-0.9, tangential), abs=1e-6)


@pytest.mark.parametrize("steps", ["fixed", "exact"])
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=needs(name)) for name in ("pybullet", "pymunk")]
)
def test_balls_that_stay_in_contact_collide_once(name: str, steps: str) -> None:
    """Balls that move on together, in contact only by rounding, must not collide in each step."""
    scene = head_on(restitution=0.0).model_copy(update={"t_max": 0.5})
    result = play(f"{name}:contact_steps={steps}", scene)
    assert result.collision_counts["ball-ball"] == 1
    assert result.work["steps"] < 1500


@pytest.mark.parametrize(
    ("spec", "degrees"),
    of_each(
        dict.fromkeys(
            ("box2d:bullet=no", "dart", "mujoco", "newton", "physx", "pybullet", "pymunk"), 0.70
        )
        | {"box2d3": 0.61, "rapier": 0.68}
    ),
)
def test_a_cut_is_late_by_a_part_of_the_step(spec: str, degrees: float) -> None:
    """The error is geometric: similar in all engines that detect overlaps at the end of a step."""
    assert np.abs(cut_angles(spec, 1e-3)).max() == pytest.approx(degrees, abs=0.05)


@pytest.mark.parametrize(
    ("name", "most"),
    of_each({"box2d3": 0.15, "newton": 0.08, "pybullet": 0.08, "pymunk": 0.08, "rapier": 0.08}),
)
def test_a_smaller_step_mends_a_cut(name: str, most: float) -> None:
    assert np.abs(cut_angles(name, 1e-4)).max() < most


@pytest.mark.parametrize(
    ("name", "error"),
    of_each(
        {
            "dart": 1e-6,
            "mujoco": 1e-6,
            "pybullet": 1e-6,
            "pymunk": 1e-6,
            "physx": 2e-3,
            "box2d": 2e-3,
            "box2d3": 1e-3,
            "newton": 2e-3,
            "rapier": 1e-3,
        }
    ),
)
def test_a_cut_in_exact_steps_is_right(name: str, error: float) -> None:
    assert np.abs(cut_angles(f"{name}:contact_steps=exact", 0.02)).max() < error


SHOTS = ("half-ball-cut", "throw-slip", "throw-stick")


@pytest.mark.parametrize(
    ("name", "shots", "error"),
    [
        pytest.param(name, shots, error, marks=needs(name), id=name)
        for name, shots, error in (
            ("box2d", (*SHOTS, "english-check"), 5e-5),
            ("dart", (*SHOTS, "draw-shot", "cradle"), 2e-4),
            ("mujoco", ("half-ball-cut", "restitution-bounce", "draw-shot"), 1e-6),
            ("mujoco", ("unequal-balls", "corner-exact", "unbounded-cut"), 1e-5),
            ("newton", (*SHOTS, "draw-shot", "restitution-cut", "unequal-balls"), 1e-4),
            ("physx", (*SHOTS, "draw-shot", "restitution-cut"), 1e-4),
            ("pybullet", ("half-ball-cut", "unequal-balls", "restitution-cut"), 1e-8),
            ("pymunk", (*SHOTS, "unequal-balls", "restitution-cut"), 1e-8),
        )
    ],
)
def test_shots_in_exact_steps_are_right(name: str, shots: tuple[str, ...], error: float) -> None:
    """Also fails if the friction or restitution of one ball is used for all pairs."""
    for scene in map(find_scene, shots):
        found = play(f"{name}:contact_steps=exact", scene).rest_positions
        assert np.abs(found - simulate(scene).rest_positions).max() < error, scene.name


@pytest.mark.parametrize(
    ("spec", "error"),
    of_each(
        {
            "box2d": 1e-3,
            "newton": 1e-5,
            "physx": 1e-4,
            "mujoco": 2.5e-4,
            "mujoco:contact_steps=exact": 2.5e-4,
        }
    ),
)
def test_a_frozen_line_collides_at_once(spec: str, error: float) -> None:
    """The result of Moreau's law; with successive collisions it would be (0, 0, 1)."""
    assert shares(spec, frozen_line()) == pytest.approx([-1 / 3, 2 / 3, 2 / 3], abs=error)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=needs(name)) for name in ("box2d3", "newton", "rapier")]
)
def test_events_are_those_of_the_shot(name: str) -> None:
    result = play(name, to_the_wall(), record="events")
    assert result.collision_counts == {"ball-ball": 0, "ball-cushion": 1}
    assert play(name, head_on()).collision_counts["ball-ball"] == 1


@pytest.mark.parametrize(
    "name",
    [pytest.param(one, marks=needs(one)) for one in ("pybullet", "mujoco", "planck", "cannon-es")],
)
def test_the_cloth_slows_a_ball_on_both_sides_of_a_bounce(name: str) -> None:
    """A step that starts with a contact must use the friction after the contact (effect 0.3 mm)."""
    scene = find_scene("rail-into")
    assert np.abs(play(name, scene).rest_positions - simulate(scene).rest_positions).max() < 1e-6


@pytest.mark.parametrize(
    ("name", "motion"),
    [
        pytest.param(name, motion, marks=needs(name))
        for name, motion in (
            ("pybullet", "rolling"),
            ("pybullet", "sliding"),
            ("planck", "rolling"),
        )
    ],
)
def test_a_recorded_ball_turns_where_the_engine_saw_it_collide(name: str, motion: str) -> None:
    """Without a frame at the contact, the motion from frames would cut the corner."""
    physics = {"motion": motion, "sliding_friction": 0.2, "ball_restitution": 0.9}
    cloth = physics if motion == "sliding" else {}
    scene = scene_of(ball((0, 0), (1, 0)), ball((0.3, 0.02)), rolling_friction=0.1, **cloth)
    spec = f"{name}:dt=5e-3" + ",bullet=no" * (name == "planck")
    result = play(spec, scene, record="trajectory")
    collision = result.events[result.events["kind"] == EventKind.BALL_BALL][0]
    times = result.trajectory.times
    before, after = np.flatnonzero(times == collision["t"])[-2:]
    places, velocities = result.trajectory.positions, result.trajectory.velocities
    np.testing.assert_array_equal(places[before], places[after])
    assert velocities[before, 1, 0] == 0.0 < velocities[after, 1, 0]
    energy = result.energy(times).total
    assert energy[after] <= energy[before]
    assert times[-1] == result.rest_time
    assert result.work["contacts_solved"] >= 1
