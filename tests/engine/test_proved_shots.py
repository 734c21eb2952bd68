"""Tests of random shots, unusual shots and shots with many balls against certified results.

The engine has exactly the certified events, in the certified order, and the rest positions agree
within 32 roundings of the state per event. The comparison ends where the certified result or the
predictability in double precision ends. `ghostball validate` makes the same comparison for shipped
scenes.
"""

import pytest
from grown import self_reported_growth
from right_shots import broken
from shots import kept_scene

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Scene, Table
from ghostball.reference_adapters.certified import CertifiedSettings
from ghostball.validation.scenes.gases import FRICTIONLESS, FULL_CLOTH, packed_gas
from ghostball.validation.scenes.random_scenes import PROVABLE, random_scene
from ghostball.validation.truth.scene_truth import truth_of

PROOF = CertifiedSettings(max_events=500, max_precision=848)
"""Limits on certifying a random shot: a few shots need thousands of events or bits."""

BATCH = 10
"""Number of random shots in a test."""

LEAST_PROVED = 5
"""Number of random shots of a test that must be certified up to their ends.

The other shots are certified up to a resting contact, a tie, or bounces that no precision resolves.
"""

SHAPES = {**PROVABLE, "table": ("polygon", "pockets", "posts")}
OVER_SHAPES = {**SHAPES, "flight": ("low", "jump", "drop", "on-top")}


def judged(result, settings=None, least=None):
    """Return the limits that a run fails against its certified result.

    The second value is whether the certified result is complete.
    """
    truth = truth_of(result.scene, settings=settings, least=least)
    faults = broken(result, truth=truth)
    proof, graded = truth.certificate, truth.graded
    if not faults and graded is not None:
        faults += self_reported_growth(result, proof, graded.until)
    return faults, proof.proved


@pytest.mark.compiled
@pytest.mark.parametrize(
    ("having", "first"),
    [*((PROVABLE, first) for first in range(0, 100, BATCH)), (SHAPES, 0), (OVER_SHAPES, 0)],
    ids=[*(f"table-{first}" for first in range(0, 100, BATCH)), "shape-0", "over-shapes-0"],
)
def test_random_shots_are_as_proved(having, first):
    scenes = [random_scene(number, **having) for number in range(first, first + BATCH)]
    found = {
        scene.name: judged(simulate(scene, record="trajectory"), PROOF, least=0) for scene in scenes
    }
    assert {name: faults for name, (faults, _) in found.items() if faults} == {}
    assert sum(proved for _, proved in found.values()) >= LEAST_PROVED


@pytest.mark.parametrize("physics", [FRICTIONLESS, FULL_CLOTH], ids=["elastic", "sliding"])
def test_shots_scheduled_with_cells_are_as_certified(physics):
    scene = packed_gas(110, 0.3, physics, t_max=0.03, seed=0)
    result = simulate(scene, record="trajectory")
    assert result.collision_counts["ball-ball"] > 10
    assert result.work["cell_moves"] > 10
    assert judged(result) == ([], True)


def test_a_ball_that_its_spin_returns_to_the_cushion_is_as_certified():
    """The ball still slides when it comes back."""
    scene = Scene(
        name="thrown-back",
        table=Table(length=2.54, width=1.27),
        physics=Physics(motion="sliding", sliding_friction=0.2),
        balls=[
            Ball(
                id="cue",
                position=(0.06, 0.3),
                velocity=(0.3, 0.05),
                angular_velocity=(0.0, -250.0, 0.0),
            )
        ],
    )
    assert judged(simulate(scene, record="trajectory")) == ([], True)


def test_friction_between_balls_while_the_cloth_changes_spin_is_as_certified():
    cue = Ball(
        id="cue", position=(0.6, 0.4), velocity=(1.2, 0.9), angular_velocity=(60.0, -40.0, 30.0)
    )
    object_ball = Ball(id="1", position=(0.86, 0.6))
    scene = Scene(
        name="hit-while-sliding", physics=Physics(preset="pool"), balls=[cue, object_ball]
    )
    assert judged(simulate(scene, record="trajectory")) == ([], True)


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("rail", ["bottom", "top"])
@pytest.mark.parametrize("preset", ["wpa-9ft", "bar-7ft", "snooker-12ft"])
def test_a_ball_that_glides_along_a_rail_touches_no_jaw_of_the_side_pocket(preset, rail, backwards):
    """Fails if a jaw sticks out beyond its nose by rounding: the mirror image then differs."""
    shot = kept_scene("along-side-pocket")
    table = Table.model_validate(preset)
    (ball,) = shot.balls
    x, y, vx = table.length / 2.0 - 0.5, ball.radius, ball.velocity[0]
    place = (table.length - x if backwards else x, table.width - y if rail == "top" else y)
    velocity = (-vx if backwards else vx, 0.0)
    glides = Ball(id="a", position=place, velocity=velocity, radius=ball.radius)
    scene = Scene(name="glides", physics=shot.physics, table=table, t_max=2.5, balls=[glides])
    result = simulate(scene, record="trajectory")
    assert abs(result.rest_positions[0, 0] - place[0]) > 0.7  # well past the pocket
    assert not any(result.collision_counts.values())
    assert judged(result) == ([], True)
