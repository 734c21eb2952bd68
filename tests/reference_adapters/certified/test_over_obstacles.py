"""Certificates with balls in the air above pockets, posts and polygons."""

from __future__ import annotations

import pytest
from right_shots import broken
from shots import R

from ghostball.engine import simulate
from ghostball.engine.motion import flight
from ghostball.model import Scene, Table
from ghostball.reference_adapters.certified import Certificate, certify, over_obstacles
from ghostball.validation.scenes.random_scenes import ASPECTS, PROVABLE, random_scene
from ghostball.validation.truth.scene_truth import truth_of

SIDE = next(hole for hole in Table.model_validate("wpa-9ft").holes if hole.pocket == 1)
ALOFT = tuple(how for how in ASPECTS["flight"] if how != "no")


def thrown_at_side_pocket(height_there: float, distance: float, aside: float = 0.0) -> Certificate:
    """Certify a ball thrown horizontally at the bottom side pocket.

    `height_there` [m]: height of the ball after a horizontal distance `distance` [m].
    """
    start = (SIDE.centre[0] + aside, 0.5, height_there + 0.5 * 9.81 * (distance / 2.0) ** 2)
    scene = {
        "name": "thrown",
        "table": "wpa-9ft",
        "physics": {"preset": "pool-coulomb", "airborne": True},
        "balls": [{"id": "cue", "position": start, "velocity": (0.0, -2.0, 0.0)}],
    }
    return certify(Scene.model_validate(scene), cached=False)


def test_the_rule_of_holes_is_the_engine_s():
    assert over_obstacles.HIGHEST_AT_BACK == flight.HIGHEST_AT_BACK


def ends(proof: Certificate) -> list[tuple[str, int]]:
    return [(event.kind.label, event.b) for event in proof.events]


def test_a_landing_in_a_hole_is_proved():
    proof = thrown_at_side_pocket(R, 0.5 - SIDE.centre[1])
    assert proof.proved
    assert ends(proof) == [("pocketed", 1)]


@pytest.mark.parametrize(("radii", "kind"), [(1.399, "pocketed"), (1.401, "leaves-table")])
def test_so_is_how_high_it_is_at_the_far_edge(radii: float, kind: str):
    proof = thrown_at_side_pocket(radii * R, 0.5 - SIDE.centre[1] + SIDE.radius)
    assert proof.proved
    assert [label for label, _ in ends(proof)] == [kind]


def test_near_a_jaw_nothing_is_decided():
    proof = thrown_at_side_pocket(1.2 * R, 0.5, aside=0.06)
    assert proof.ending == "ambiguous"
    assert not proof.events


@pytest.mark.parametrize("kind", ["polygon", "pockets", "posts"])
@pytest.mark.parametrize("seed", range(6))
def test_our_engine_agrees_with_the_certificate(kind: str, seed: int):
    scene = random_scene(seed, **{**PROVABLE, "table": kind, "flight": ALOFT})
    assert broken(simulate(scene, record="trajectory"), truth=truth_of(scene)) == []
