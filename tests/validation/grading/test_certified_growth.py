"""The grader's tangent map agrees with proofs of slightly changed shots and with closed forms."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from grown import self_reported_growth
from numpy.typing import NDArray
from proofs import integrated_once
from shots import POOL_TABLE, R, ball, scene_of
from tangent import carried

from ghostball.engine import simulate
from ghostball.model import Scene
from ghostball.reference_adapters.certified import certify
from ghostball.reference_adapters.certified.certificate import segment_columns
from ghostball.validation.grading.certified_growth import CertifiedGrowth, growth_of_certificate
from ghostball.validation.grading.gradable import motion_of_certificate
from ghostball.validation.grading.horizon import horizon
from ghostball.validation.grading.lateness import lateness_of
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.scenes.random_scenes import PROVABLE, random_scene

CHANGE = 1e-9
"""Largest difference of two shots [m]; its second order is 1e-9 of it."""

LAWS = (
    "half-ball-cut",
    "restitution-cut",
    "unequal-balls",
    "draw-shot",
    "masse",
    "throw-slip",
    "throw-stick",
    "throw-alciatore",
    "english-check",
    "han-running",
    "around-the-table",
    "break-7",
)
"""Scenes with each impact law and each kind of motion that can be certified."""

AIR = {"preset": "pool", "air_drag": 0.05}

IN_AIR = {
    "rolls": scene_of(ball((0.5, 0.1), (2.0, 0.5)), air_drag=0.1),
    "rolls, slowed by the square alone": scene_of(
        ball((0.5, 0.1), (2.0, 0.5)), rolling_friction=0.0, air_drag=0.1, t_max=3.0
    ),
    "a cut of rolling balls": scene_of(
        ball((0.5, 0.6), (2.0, 0.0)),
        ball((1.0, 0.63)),
        air_drag=0.1,
        rolling_friction_quadratic=0.008,
    ),
    "slides into rolling": scene_of(
        ball((0.0, 0.0), (3.0, 0.2), angular_velocity=(-50.0, 60.0, 5.0)), **AIR
    ),
    "slides without friction": scene_of(
        ball((0.1, 0.2), (3.0, 0.2), angular_velocity=(-50.0, 60.0, 5.0)),
        **{**AIR, "sliding_friction": 0.0},
        t_max=2.0,
    ),
    "a bounce off a cushion": scene_of(
        ball((2.0, 0.6), (3.0, 0.7), angular_velocity=(-10.0, 20.0, 30.0)), table=POOL_TABLE, **AIR
    ),
    "a cut of sliding balls": scene_of(
        ball((0.5, 0.6), (2.0, 0.0), angular_velocity=(10.0, -30.0, 20.0)),
        ball((1.0, 0.63)),
        table=POOL_TABLE,
        **AIR,
    ),
    "a draw that comes back": scene_of(
        ball((0.5, 0.5), (1.0, 0.01), angular_velocity=(2.0, -140.0, 3.0)), **AIR
    ),
}


SLIDES_IN_AIR = {
    "slides into rolling",
    "a bounce off a cushion",
    "a cut of sliding balls",
    "a draw that comes back",
}
"""Shots of `IN_AIR` that can't be certified."""


def rounding_horizon(growth: CertifiedGrowth) -> float:
    return horizon(growth, 1e-3, 2.0**-48)


def changed(scene: Scene, change: NDArray[np.float64]) -> Scene:
    """Return the scene with a changed state of each ball, (n, 7); rolling balls still roll."""
    balls = []
    for one, rolls, spin, d in zip(
        scene.balls, scene.rolls, scene.angular_velocities, change, strict=True
    ):
        update = {
            "position": tuple(np.add(one.position[:2], d[:2])),
            "velocity": tuple(np.add(one.velocity[:2], d[2:4])),
        }
        vx, vy = update["velocity"]
        turns = (-vy / one.radius, vx / one.radius, spin[2]) if rolls else tuple(spin + d[4:])
        update["angular_velocity"] = turns
        balls.append({**one.model_dump(exclude_none=True), **update})
    return Scene.model_validate({**scene.model_dump(by_alias=True), "balls": balls})


def state(scene: Scene) -> NDArray[np.float64]:
    """Return the state of each ball, (n, 7); the spin of a rolling ball is set to 0."""
    spins = np.where(scene.rolls[:, np.newaxis], 0.0, scene.angular_velocities)
    return np.hstack([scene.positions[:, :2], scene.velocities[:, :2], spins])


@pytest.mark.parametrize("name", [*LAWS, *IN_AIR])
def test_changes_become_what_proofs_of_changed_shots_say(name: str) -> None:
    # Fails if a sign, a factor or a term is wrong, or if the growth is 30 times too large.
    scene = IN_AIR[name] if name in IN_AIR else find_scene(name)
    known = integrated_once if name in SLIDES_IN_AIR else partial(certify, motion=True)
    growth = growth_of_certificate(scene, known(scene))
    chance = np.random.default_rng(11)
    direction = chance.normal(size=(len(scene.balls), 7)) * np.abs(state(scene))
    direction[:, :2] = 0.01 * chance.normal(size=(len(scene.balls), 2))
    end = np.array([growth.t_end])
    largest = np.max(np.abs(carried(growth, direction[np.newaxis], end)))
    sides = [changed(scene, sign * CHANGE / largest * direction) for sign in (1.0, -1.0)]
    # The numbers of the scenes are rounded, so the prediction starts from their actual difference.
    real = (state(sides[0]) - state(sides[1]))[np.newaxis]
    predicted = carried(growth, real, end)[0, 0]
    proofs = [known(side) for side in sides]
    assert all(proof.proved for proof in proofs)
    ends = [np.array([[e.mid for e in place] for place in proof.positions]) for proof in proofs]
    difference = (ends[0] - ends[1]).astype(np.float64)
    assert difference == pytest.approx(predicted, abs=1e-5 * np.max(np.abs(predicted)))


def test_rounding_displaces_a_rolling_ball_by_its_place_and_its_way() -> None:
    # x and vx are rounded once; y and vy are exactly 0 and stay so.
    scene = scene_of(ball((0.5, 0.0), (2.0, 0.0)), rolling_friction=0.02, table=None)
    growth = growth_of_certificate(scene, certify(scene, motion=True))
    for t in (0.0, 1.5):
        assert growth.sizes([t])[0, 0] == pytest.approx(math.hypot(0.5 + R, 2.0 * t))


@pytest.mark.parametrize("depth", [1e-3, 1e-6, 1e-9])
def test_a_thin_hit_amplifies_the_rounding_of_the_distance_from_the_start(depth: float) -> None:
    """Fails if only positions are rounded: a thin hit also amplifies the rounding of the distance.

    Two discs of diameter D at an offset (1 - d) D touch at c D = sqrt(2 d - d^2) D along the path.
    An error D of their distance becomes D / c along the path. It turns the normal by 1 / c, and so
    displaces the object ball, which leaves at c v, by 1 / c over its path; the speed changes by v
    (1 - d) / c.
    """
    aside, way = 2.0 * R * (1.0 - depth), 0.1
    scene = scene_of(
        ball((-way, aside), (1.0, 0.0)), ball((0.0, 0.0)), rolling_friction=0.0, t_max=1
    )
    growth = growth_of_certificate(scene, certify(scene, motion=True))
    along = math.sqrt(2.0 * depth - depth**2)
    left = 1.0 - (way - 2.0 * R * along)
    assert growth.sizes([1.0])[0, 1] == pytest.approx(left / along, rel=0.2)
    states = growth_of_certificate(scene, certify(scene, motion=True), gaps=False)
    assert states.sizes([1.0])[0, 1] < 0.3 * growth.sizes([1.0])[0, 1]


@pytest.mark.parametrize(
    ("physics", "by_speed"),
    [
        ({"preset": "paper", "air_drag": 0.1}, 1.854461835175432),
        ({"preset": "paper", "air_drag": 0.0041}, 16.739203213927016),
        ({"preset": "pool", "air_drag": 0.1}, 2.654189448459432),
        ({"preset": "paper"}, 25.4841997961264),
    ],
)
def test_a_faster_ball_rolls_farther_in_air_as_worked_numbers_say(
    physics: dict[str, Any], by_speed: float
) -> None:
    """Fails if the growth ignores the air: distance per speed is v / (a + b v^2), at 5 m/s."""
    scene = scene_of(ball((0.0, 0.0), (5.0, 0.0)), **physics)
    growth = growth_of_certificate(scene, certify(scene, motion=True))
    change = np.zeros((1, 1, 7))
    change[0, 0, 2] = 1.0
    moved = carried(growth, change, np.array([growth.t_end]))[0, 0, 0]
    assert moved == pytest.approx([by_speed, 0.0], rel=1e-14)
    assert rounding_horizon(growth) == math.inf
    assert np.isfinite(growth.sizes(np.linspace(0.0, growth.t_end, 50))).all()


def test_what_rounding_does_is_the_sum_over_all_that_is_rounded() -> None:
    # The covariance agrees with separate changes of each number of a ball, before the first event.
    scene = find_scene("half-ball-cut")
    growth = growth_of_certificate(scene, certify(scene, motion=True))
    t = math.nextafter(growth.times[1], 0.0)
    x, y, vx, vy = state(scene)[0, :4]
    sizes = [abs(x) + R, abs(y) + R if vy else 0.0, abs(vx), abs(vy)]
    changes = np.zeros((4, 2, 7))
    for k, one in enumerate(sizes):
        changes[k, 0, k] = one
    moved = carried(growth, changes, np.array([t]))[0, :, 0]
    assert growth.sizes([t])[0, 0] == pytest.approx(np.linalg.norm(moved))


def test_there_is_no_derivative_past_two_collisions_at_one_instant() -> None:
    scene = find_scene("frozen-to-cushion")
    growth = growth_of_certificate(scene, certify(scene, motion=True))
    assert 0.0 < growth.derivative_ends < growth.t_end
    assert np.isfinite(growth.sizes([math.nextafter(growth.derivative_ends, 0.0)])).all()
    assert np.isinf(growth.sizes([growth.derivative_ends])).any()
    assert rounding_horizon(growth) == math.inf


def test_our_engines_sample_of_roundings_is_as_near_as_it_says() -> None:
    # Fails if two roundings have the same signs: the errors of two colliding balls would cancel,
    # and the errors of one ball would add up over thousands of impacts.
    ratios = []
    shots = [random_scene(number, **PROVABLE, flight="no") for number in range(48)]
    for scene in (*shots, find_scene("galperin-2"), find_scene("galperin-3")):
        result, proof = simulate(scene, record="trajectory"), certify(scene, motion=True)
        right = growth_of_certificate(scene, proof).sizes([result.rest_time])[0]
        said = result.sensitivity([result.rest_time])[0]
        some = np.isfinite(right) & np.isfinite(said) & (right > 0.0)
        if proof.proved:
            ratios.append(said[some] / right[some])
    off = np.concatenate(ratios) - 1.0
    assert len(off) > 80
    assert np.sqrt(np.mean(off**2)) < 0.16
    assert np.abs(off).max() < 0.6


def test_in_air_growth_continues_through_every_piece_of_the_motion() -> None:
    """Fails if the growth at an event is lost in the further pieces of the motion's series."""
    scene = IN_AIR["a cut of sliding balls"]
    proof = integrated_once(scene)
    growth = growth_of_certificate(scene, proof)
    assert proof.segments is not None
    for i, (segments, starts) in enumerate(zip(proof.segments, proof.starts, strict=True)):
        inner = np.delete(segments[:, 0], starts)
        inner = inner[inner < segments[-1, 0] - 1e-6]
        assert len(inner) > 10
        before, after = (growth.sizes(inner + d)[:, i] for d in (-1e-13, 1e-13))
        assert after == pytest.approx(before, rel=1e-6)
        assert np.isfinite(after).all()


def test_of_flight_nothing_is_said() -> None:
    """Fails if a proof with airborne balls is treated like a proof on the cloth."""
    scene = find_scene("half-ball-cut")
    proof = certify(scene, motion=True)
    assert proof.segments is not None
    segments = tuple(np.insert(rows, [14] * 3, 0.0, axis=1) for rows in proof.segments)
    flies = replace(proof, segments=segments, columns=segment_columns(lifts=True))
    growth = growth_of_certificate(scene, flies)
    assert growth.derivative_ends == 0.0
    assert np.isinf(growth.sizes([0.0, 0.5])).all()
    assert rounding_horizon(growth) == math.inf
    assert np.isnan(lateness_of(growth, scene, motion_of_certificate(scene, flies)).places).all()
    directions = np.ones((1, 2, 7))
    assert np.isnan(carried(growth, directions, np.array([0.5]))).all()


@pytest.mark.parametrize("scene", ["half-ball-cut", "throw-slip", "three-cushions"])
def test_what_the_engine_says_of_its_growth_is_what_the_proof_says(scene: str) -> None:
    """Fails if the engine's tangent map or horizon differs too much from the proof."""
    result = simulate(find_scene(scene), record="trajectory")
    assert self_reported_growth(result, certify(result.scene, motion=True)) == []


@pytest.mark.parametrize("factor", [30.0, 1000.0, 1.0 / 30.0])
def test_growth_that_an_engine_inflates_is_seen(
    factor: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = find_scene("half-ball-cut")
    result, proof = simulate(scene, record="trajectory"), certify(scene, motion=True)
    right = type(result.rounding).growth
    monkeypatch.setattr(type(result.rounding), "growth", lambda *a: factor * right(*a))
    assert any(
        "`sensitivity` of ball" in fault for fault in self_reported_growth(replace(result), proof)
    )


def test_a_horizon_that_an_engine_makes_up_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = find_scene("half-ball-cut")
    result, proof = simulate(scene, record="trajectory"), certify(scene, motion=True)
    monkeypatch.setattr(type(result), "horizon", lambda *_: 0.1)
    (fault,) = self_reported_growth(result, proof)
    assert fault.startswith("`horizon()` is 0.1 s")
