"""Closed forms agree with conservation laws, published formulas and numbers, and pi.

`certified/test_api.py` checks that each form lies within the enclosures of its proof.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from mpmath import mp
from numpy.typing import NDArray
from right_shots import stress_shots

from benchmarks.pictures.physics import PUBLISHED_DEFLECTIONS
from ghostball.model import Ball, Physics, Scene, Table
from ghostball.reference_adapters.certified import certify
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.stress import StressSize
from ghostball.validation.truth.closed_forms import DIGITS, ClosedForm, closed_form, has_closed_form
from ghostball.validation.truth.closed_forms._setup import numbers_of
from ghostball.validation.truth.scene_truth import truth_of

FloatArray = NDArray[np.float64]

R = 0.028575


def solved(name: str, **changes: Any) -> tuple[Scene, ClosedForm]:
    scene = find_scene(name).model_copy(update=changes)
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


@pytest.mark.parametrize("k", range(4))
def test_galperin_counts_are_the_digits_of_pi(k: int) -> None:
    _, form = solved(f"galperin-{k}")
    with mp.workdps(DIGITS):
        assert sum(form.collision_counts.values()) == int(mp.pi * 10**k)


# --- published formulas and numbers


def physics_of(scene: Scene) -> tuple[float, float, float]:
    physics = scene.physics
    return physics.gravity, physics.sliding_friction, physics.rolling_friction


def cut_shot(cut: float) -> Scene:
    """Return a rolling cue ball that hits a resting ball at a cut angle [deg], at 1 m/s."""
    offset = 2 * R * math.sin(math.radians(cut))
    ahead = 2 * R * math.cos(math.radians(cut))
    speed = math.sqrt(1.0 + 2 * 0.02 * 9.81 * 0.1)
    return Scene(
        name="half-ball-rolling",
        physics=Physics(motion="sliding"),
        balls=(
            Ball(id="cue", position=(-ahead - 0.1, -offset), velocity=(speed, 0.0)),
            Ball(id="object", position=(0.0, 0.0)),
        ),
        t_max=0.7,
    )


@pytest.mark.parametrize(("cut", "deflection"), PUBLISHED_DEFLECTIONS)
def test_deflections_are_the_published_ones(cut: float, deflection: float) -> None:
    form = closed_form(cut_shot(cut))
    assert form is not None
    vx, vy = as_array(form.final_velocities)[0]
    assert math.degrees(math.atan2(-vy, vx)) == pytest.approx(deflection, abs=1e-3)


@pytest.mark.parametrize(("cut", "cue", "target"), [(30.0, 0.55787, 0.61859)])
def test_speeds_after_the_slide_are_the_published_ones(
    cut: float, cue: float, target: float
) -> None:
    # Alciatore TP A.16, as fractions of the speed at the collision; both balls roll at t_max.
    form = closed_form(cut_shot(cut))
    assert form is not None
    speeds = np.linalg.norm(as_array(form.final_velocities), axis=1)
    # The collision comes after v0 t - a t^2 / 2 = 0.1 m. From 1 m/s, each ball then slides for
    # 2 |u| / (7 mu_s g).
    collision = (math.sqrt(1.0 + 0.04 * 9.81 * 0.1) - 1.0) / (0.02 * 9.81)
    slip = math.cos(math.radians(cut))
    rolled = 0.7 - collision - 2 * slip / (7 * 0.2 * 9.81)
    np.testing.assert_allclose(speeds + 0.02 * 9.81 * rolled, [cue, target], rtol=0, atol=1e-5)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("throw-slip", math.degrees(math.atan(0.06))),
        ("throw-stick", math.degrees(math.atan(math.tan(math.radians(15.0)) / 7))),
        ("gearing", 0.0),
    ],
)
def test_throw_is_that_of_the_proof(name: str, expected: float) -> None:
    # Alciatore TP A.14: tan(throw) = min(mu, tan(cut) / 7), and 0 if the balls don't slip.
    scene, form = solved(name, t_max=0.5)
    vx, vy = as_array(form.final_velocities)[1]
    cut = math.asin((scene.positions[1, 1] - scene.positions[0, 1]) / (2 * R))
    assert math.degrees(cut - math.atan2(vy, vx)) == pytest.approx(expected, abs=1e-9)


def test_roll_distance_is_the_published_one() -> None:
    # Alciatore TP B.6: 1.5 mph, 7.522 ft.
    scene, form = solved("roll-distance")
    assert scene.velocities[0, 0] == pytest.approx(1.5 * 0.44704, abs=1e-12)
    feet = (float(form.rest_positions[0][0]) - scene.positions[0, 0]) / 0.3048
    assert feet == pytest.approx(7.522, abs=5e-4)


def test_symmetric_collision_leaves_the_speeds_of_its_formula() -> None:
    # The speeds are (2 - 3 e) / 5 and (sqrt(3) / 5)(1 + e); stopping distances grow with their
    # squares.
    scene, form = solved("three-ball-symmetric")
    contact = scene.positions[1, 0] - R * math.sqrt(3)
    v2 = 1.0 - 2 * 0.02 * 9.81 * (contact - scene.positions[0, 0])
    ends = as_array(form.rest_positions) - [[contact, 0.0], [0.5, R], [0.5, -R]]
    distances = np.linalg.norm(ends, axis=1) * 2 * 0.02 * 9.81 / v2
    np.testing.assert_allclose(distances, [1 / 25, 12 / 25, 12 / 25], rtol=1e-12)
    assert ends[0, 0] < 0
    np.testing.assert_array_equal(ends[1], ends[2] * [1, -1])


def test_a_pushed_ball_keeps_the_books() -> None:
    # The energy of the spin equals the work of friction on the sliding and the rolling ball.
    scene, form = solved("push")
    g, mu_s, mu_r = physics_of(scene)
    travelled = float(form.rest_positions[0][0]) - scene.positions[0, 0]
    a = (5 * mu_s - 7 * mu_r) * g / 12
    surface = R * scene.angular_velocities[0, 1]
    slide = surface / (a + 2.5 * mu_s * g)
    slid = surface * slide / 2  # the slip decreases linearly to 0
    pushed = a * slide**2 / 2
    work = mu_s * g * slid + 1.4 * mu_r * g * (pushed + 2 * (travelled - pushed))
    assert work == pytest.approx(0.2 * surface**2, rel=1e-12)


@pytest.mark.parametrize("name", ["thirty-degree-rule", "throw-by-angle", "throw-by-spin"])
def test_a_sweep_is_its_shots(name: str) -> None:
    # Each pair has the rest positions of a separate shot: fails if pairs are mixed up. Four pairs
    # are enough, because each change of a shared number solves all pairs again.
    balls = find_scene(name).balls
    scene, form = solved(name, balls=tuple(b for k in (0, 6, 12, 20) for b in balls[k : k + 2]))
    for k in range(0, len(scene.balls), 2):
        alone = closed_form(
            scene.model_copy(update={"name": "half-ball-rolling", "balls": scene.balls[k : k + 2]})
        )
        assert alone is not None
        assert alone.rest_positions == form.rest_positions[k : k + 2]
        np.testing.assert_allclose(alone.conditioning, form.conditioning[k : k + 2], rtol=1e-12)


# --- conditioning


def test_conditioning_of_a_straight_roll_is_that_of_the_formula() -> None:
    # For x + v^2 / (2 mu g), the sum is |x|, |y|, and the distance four times: twice for v, once
    # each for mu and g.
    scene = Scene(name="stop", balls=(Ball(id="cue", position=(0.5, 0.25), velocity=(0.8, 0.0)),))
    form = closed_form(scene)
    assert form is not None
    distance = 0.8**2 / (2 * 0.02 * 9.81)
    assert form.conditioning[0] == pytest.approx(0.5 + 0.25 + 4 * distance, rel=1e-12)
    # For v / (mu g), the sum is the time three times.
    assert form.rest_time_conditioning == pytest.approx(3 * 0.8 / (0.02 * 9.81), rel=1e-12)


@pytest.mark.parametrize("name", ["thin-cut", "around-the-table", "moving-moving", "galperin-2"])
def test_conditioning_bounds_what_rounding_the_inputs_does(name: str) -> None:
    # Change x, v and m of the first ball by 1e-9 of their values: the rest positions change by at
    # most 1e-9 times the conditioning, but not by 0.
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


@pytest.mark.parametrize(
    ("name", "numbers"),
    [
        ("masse", {("spin", 0, 0), ("spin", 0, 1), ("spin", 0, 2), ("sliding_friction",)}),
        ("throw-slip", {("ball_friction",), ("ball_restitution",), ("spin", 0, 1)}),
        ("han-check", {("cushion_friction",), ("cushion_height",), ("cushion_restitution",)}),
        ("han-check", {("spin", 0, 2), ("spinning_friction_rate",)}),
    ],
)
def test_conditioning_counts_spin_and_every_coefficient(name: str, numbers: set[Any]) -> None:
    # Fails if the rounding of a number is omitted that the shot depends on.
    scene, form = solved(name)
    assert numbers <= set(numbers_of(scene))
    relative, fields = 1e-9, {}
    for key in numbers:
        if len(key) == 1:
            fields[key[0]] = getattr(scene.physics, key[0]) * (1 + relative)
    moved = closed_form(
        scene.model_copy(update={"physics": scene.physics.model_copy(update=fields)})
    )
    assert moved is not None
    shift = np.hypot(*(as_array(moved.rest_positions) - as_array(form.rest_positions)).T)
    assert np.all(shift <= relative * form.conditioning * (1 + 1e-3))


# --- what has no closed form


def moved_balls(name: str, index: int, by: float) -> dict[str, Any]:
    """Return the balls of a scene, with one ball moved along y."""
    balls = list(find_scene(name).balls)
    x, y, z = balls[index].position
    balls[index] = balls[index].model_copy(update={"position": (x, y + by, z)})
    return {"balls": tuple(balls)}


def more_balls(name: str, *more: Ball) -> dict[str, Any]:
    return {"balls": (*find_scene(name).balls, *more)}


SLIDES = find_scene("air-slides").balls[0]
ELASTIC = find_scene("flight-throw").physics.model_copy(update={"table_restitution": 1.0})
DROP = Ball(id="let-go", position=(0.0, 0.0, 0.2))


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("stun-shot", {"physics": Physics(motion="sliding", air_drag=0.004)}),
        ("stun-shot", {"physics": Physics(motion="sliding", ball_impact="mathavan2014")}),
        ("english-check", {"physics": Physics(motion="sliding", cushion="mathavan2010")}),
        ("push", moved_balls("push", 1, 1e-9)),
        ("wedged", moved_balls("wedged", 0, 1e-9)),
        ("throw-by-angle", moved_balls("throw-by-angle", 5, 1.1)),  # into the path of another pair
        ("three-ball-symmetric", {"name": "mine"}),  # not only collisions of two balls
        # Scenes in air: changed to no air, to a slip across, or to balls that may collide.
        ("air-slides", {"physics": Physics(preset="pool")}),
        ("air-slides", {"balls": (SLIDES.model_copy(update={"angular_velocity": (1.0, 0, 0)}),)}),
        ("air-slides", moved_balls("air-slides", 0, 0.48)),
        # Falls: with a velocity aside, with a spin, and above another ball.
        ("air-drop", {"balls": (DROP, Ball(id="a", position=(0, 1, 0.2), velocity=(0.1, 0, 0)))}),
        (
            "air-drop",
            {"balls": (DROP, Ball(id="a", position=(0, 1, 0.2), angular_velocity=(0, 0, 1.0)))},
        ),
        ("air-drop", {"balls": (DROP, Ball(id="a", position=(0.0, 0.01, 0.5)))}),
        # Flights: with a near ball, with endless bounces, and under another name.
        ("flight-throw", more_balls("flight-throw", Ball(id="near", position=(2.0, 0.0)))),
        ("flight-throw", {"physics": ELASTIC, "t_max": 1.0}),
        ("flight-throw", {"name": "another"}),
    ],
)
def test_other_physics_places_or_names_have_no_form(name: str, change: dict[str, Any]) -> None:
    changed = find_scene(name).model_copy(update=change)
    assert closed_form(changed) is None
    assert not has_closed_form(changed)
    assert has_closed_form(find_scene(name))


def test_a_scene_without_a_form_has_none() -> None:
    for name in ("frozen-break", "break-7"):
        assert closed_form(find_scene(name)) is None


@pytest.mark.parametrize(
    ("change", "shape"),
    [
        ({"physics": Physics(motion="sliding")}, True),
        ({"physics": Physics(ball_friction=0.05)}, False),
        ({"physics": Physics(air_drag=0.004)}, False),
        # The object ball hits the right cushion, the cue ball misses, or the cue ball bounces
        # first.
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
    # The closed form of the shipped "head-on" must not judge a user's scene of this name.
    scene = find_scene("head-on").model_copy(update=change)
    found, unnamed = closed_form(scene), closed_form(scene.model_copy(update={"name": "mine"}))
    assert (found is not None) == (unnamed is not None) == shape
    if found is not None and unnamed is not None:
        assert found.rest_positions == unnamed.rest_positions
        assert found.event_sequence == unnamed.event_sequence


# --- a user's scene --------------------------------------------------------------------------

BY_SHAPE = ("stop", "half-ball-cut", "wall-bounce", "moving-moving", "draw-shot", "throw-slip")

BY_NAME_ALONE = ("cradle", "push", "flight-throw", "air-rolls")
"""One scene for each kind of form: simultaneous impacts, resting contact, flight, and air."""


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


@pytest.mark.parametrize(
    "shape",
    [
        {"preset": "wpa-9ft"},
        {"vertices": [(0.0, 0.0), (2.54, 0.0), (2.54, 1.27), (0.0, 1.27)]},
        {"length": 2.54, "width": 1.27, "posts": [{"centre": (2.0, 1.0), "radius": 0.1}]},
    ],
)
def test_there_is_none_of_a_table_that_is_no_plain_rectangle(shape: dict[str, Any]) -> None:
    # Fails if a form ignores the cushions, as if the cloth were unbounded.
    ball = Ball(id="cue", position=(0.5, 0.5), velocity=(2.0, 1.0))
    assert closed_form(Scene(name="roll", physics=Physics(preset="pool"), balls=[ball])) is not None
    table = Table.model_validate(shape)
    shaped = Scene(name="roll", table=table, physics=Physics(preset="pool"), balls=[ball])
    assert closed_form(shaped) is None


def test_a_shot_so_slow_that_digits_end_has_no_form() -> None:
    """Fails if a speed of 1e-49 m/s, which leads to a collision, counts as 0."""
    ((_, shot),) = stress_shots(StressSize(), "extremes/limit-elastic-1e-49")
    assert closed_form(shot.scene) is None
    assert truth_of(shot.scene).collision_counts == {"ball-ball": 1, "ball-cushion": 0}


def test_impacts_that_last_have_no_closed_form_unless_they_are_of_two_balls():
    for name, count in (("head-on", 2), ("three-ball-chain", 3)):
        scene = find_scene(name)
        assert len(scene.balls) == count
        assert has_closed_form(scene)
        physics = scene.physics.model_copy(update={"impacts": "compliant"})
        lasting = scene.model_copy(update={"physics": physics})
        assert has_closed_form(lasting) is (count == 2)
