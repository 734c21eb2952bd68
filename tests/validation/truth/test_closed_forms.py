"""Closed forms against independent checks: conservation laws, published numbers, pi itself.

That each lies within what is proved of its scene is in `certified/test_api.py`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mpmath import mp
from numpy.typing import NDArray
from right_shots import stress_shots

from ghostball.model import Ball, Physics, Scene, Table
from ghostball.reference_adapters.certified import certify
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.stress import Size
from ghostball.validation.truth.closed_forms import DIGITS, ClosedForm, closed_form
from ghostball.validation.truth.scene_truth import truth_of

FloatArray = NDArray[np.float64]


def solved(name: str) -> tuple[Scene, ClosedForm]:
    scene = find_scene(name)
    form = closed_form(scene)
    assert form is not None
    return scene, form


def as_array(vectors: Any) -> FloatArray:
    return np.array([[float(value) for value in vector] for vector in vectors])


# --- conservation, from the rest positions alone


@pytest.mark.parametrize("name", ["restitution-bounce", "english-running", "han-running"])
def test_a_restitution_that_falls_with_speed_agrees_with_its_proof(name: str) -> None:
    scene = find_scene(name)
    physics = scene.physics.model_copy(update={"cushion_restitution_loss": 0.15})
    falls = scene.model_copy(update={"physics": physics})
    form, fixed = closed_form(falls), closed_form(scene)
    assert form is not None
    assert fixed is not None
    certificate = certify(falls)
    assert certificate.proved
    for ball, (exact, proof) in enumerate(
        zip(form.rest_positions, certificate.positions, strict=True)
    ):
        assert as_array([exact[:2]])[0] == pytest.approx([float(x) for x in proof[:2]], rel=1e-14)
        assert abs(exact[0] - fixed.rest_positions[ball][0]) > 1e-3


# --- Galperin


@pytest.mark.parametrize("k", range(5))
def test_galperin_counts_are_the_digits_of_pi(k: int) -> None:
    _, form = solved(f"galperin-{k}")
    with mp.workdps(DIGITS):
        assert sum(form.collision_counts.values()) == int(mp.pi * 10**k)


# --- conditioning, and what has no closed form


def test_conditioning_of_a_straight_roll_is_that_of_the_formula() -> None:
    # x + v^2 / (2 mu g): |x| once, |y| once, the distance twice for v and once each for mu and g.
    scene = Scene(name="stop", balls=(Ball(id="cue", position=(0.5, 0.25), velocity=(0.8, 0.0)),))
    form = closed_form(scene)
    assert form is not None
    distance = 0.8**2 / (2 * 0.02 * 9.81)
    assert form.conditioning[0] == pytest.approx(0.5 + 0.25 + 4 * distance, rel=1e-12)
    # v / (mu g): once for each.
    assert form.rest_time_conditioning == pytest.approx(3 * 0.8 / (0.02 * 9.81), rel=1e-12)


@pytest.mark.parametrize("name", ["thin-cut", "around-the-table", "moving-moving", "galperin-2"])
def test_conditioning_bounds_what_rounding_the_inputs_does(name: str) -> None:
    # Nudge x, v and m of the first ball by a relative 1e-9 at once: the end moves by no more than
    # 1e-9 times the conditioning, and not by nothing.
    scene, form = solved(name)
    relative = 1e-9
    ball = scene.balls[0]
    nudged_ball = Ball(
        id=ball.id,
        position=(ball.position[0] * (1 + relative), ball.position[1]),
        velocity=(ball.velocity[0] * (1 + relative), ball.velocity[1]),
        radius=ball.radius,
        mass=ball.mass * (1 + relative),
    )
    moved = closed_form(scene.model_copy(update={"balls": (nudged_ball, *scene.balls[1:])}))
    assert moved is not None
    shift = np.hypot(*(as_array(moved.rest_positions) - as_array(form.rest_positions)).T)
    assert np.all(shift <= relative * form.conditioning * (1 + 1e-3))
    assert shift.max() > 0.01 * relative * form.conditioning.max()


def test_a_scene_without_a_form_has_none() -> None:
    assert closed_form(find_scene("break-7")) is None


@pytest.mark.parametrize(
    ("change", "shape"),
    [
        ({"physics": Physics(motion="sliding")}, True),
        ({"physics": Physics(ball_friction=0.05)}, False),
        ({"physics": Physics(air_drag=0.004)}, False),
        # The object ball now meets the right cushion, the cue ball misses, or it bounces first.
        ({"table": Table(length=1.5, width=1.27)}, True),
        (
            {
                "balls": (
                    Ball(id="a", position=(0.5, 0.5), velocity=(0.8, 0)),
                    Ball(id="b", position=(1.2, 0.635)),
                )
            },
            True,
        ),
        (
            {
                "balls": (
                    Ball(id="a", position=(0.5, 0.635), velocity=(-3.0, 0)),
                    Ball(id="b", position=(1.2, 0.635)),
                )
            },
            False,
        ),
    ],
)
def test_a_namesake_with_other_physics_or_collisions_is_not_judged_by_the_name(
    change: dict[str, Any], shape: bool
) -> None:
    # A user's own scene called "head-on" must not be judged by the form of ours.
    scene = find_scene("head-on").model_copy(update=change)
    found, unnamed = closed_form(scene), closed_form(scene.model_copy(update={"name": "mine"}))
    assert (found is not None) == (unnamed is not None) == shape
    if found is not None and unnamed is not None:
        assert found.rest_positions == unnamed.rest_positions
        assert found.event_sequence == unnamed.event_sequence


# --- a scene of one's own ----------------------------------------------------------------------

BY_SHAPE = ("stop", "half-ball-cut", "wall-bounce", "moving-moving", "draw-shot", "throw-slip")

BY_NAME_ALONE = ("cradle", "push", "flight-throw", "air-rolls")
"""Of the forms for scenes at one instant, in contact, off the cloth, and in air."""


@pytest.mark.parametrize("name", [*BY_SHAPE, *BY_NAME_ALONE])
def test_a_shot_is_solved_by_its_shape_whatever_it_is_called(name: str) -> None:
    scene, form = solved(name)
    renamed = closed_form(scene.model_copy(update={"name": "mine"}))
    assert (renamed is None) == (name in BY_NAME_ALONE)
    if renamed is None:
        return
    assert renamed.event_sequence == form.event_sequence
    with mp.workdps(DIGITS):
        for ours, theirs in zip(renamed.rest_positions, form.rest_positions, strict=True):
            assert all(abs(a - b) <= 1e-30 for a, b in zip(ours, theirs, strict=True))
        assert abs(renamed.rest_time - form.rest_time) <= 1e-30
    assert renamed.conditioning == pytest.approx(form.conditioning, rel=1e-6)


def test_a_shot_that_is_not_of_collisions_of_two_alone_has_no_form() -> None:
    for name in ("three-ball-symmetric", "frozen-break", "break-7"):
        assert closed_form(find_scene(name).model_copy(update={"name": "mine"})) is None


@pytest.mark.parametrize(
    "shape",
    [
        {"preset": "wpa-9ft"},
        {"vertices": [(0.0, 0.0), (2.54, 0.0), (2.54, 1.27), (0.0, 1.27)]},
        {"length": 2.54, "width": 1.27, "posts": [{"centre": (2.0, 1.0), "radius": 0.1}]},
    ],
)
def test_there_is_none_of_a_table_that_is_no_plain_rectangle(shape: dict[str, Any]) -> None:
    # Breaks where a form knows of no cushions, and takes the table for an unbounded one.
    ball = Ball(id="cue", position=(0.5, 0.5), velocity=(2.0, 1.0))
    assert closed_form(Scene(name="roll", physics=Physics(preset="pool"), balls=[ball])) is not None
    table = Table.model_validate(shape)
    shaped = Scene(name="roll", table=table, physics=Physics(preset="pool"), balls=[ball])
    assert closed_form(shaped) is None


def test_a_shot_so_slow_that_digits_end_has_no_form() -> None:
    """Breaks where a speed of 1e-49 m/s, which arrives, is taken for a rounding of none."""
    ((_, shot),) = stress_shots(Size(), "extremes/limit-elastic-1e-49")
    assert closed_form(shot.scene) is None
    assert truth_of(shot.scene).collision_counts == {"ball-ball": 1, "ball-cushion": 0}
