"""The grader's own tangent map: against proofs of slightly changed shots, and in closed form."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from shots import R, ball, scene_of

from ghostball.engine import Scene, simulate
from ghostball.reference_adapters.certified import certify
from ghostball.validation.grading.certified_growth import growth_of_proof
from ghostball.validation.grading.slope import Slope
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.scenes.random_shots import random_shot
from ghostball.validation.stress.proved import own_words

CHANGE = 1e-9
"""Largest displacement [m] that differences are taken over: the second order is 1e-9 of it."""

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
"""Scenes of each law of impacts and way of moving that can be proved."""


def changed(scene: Scene, change: NDArray[np.float64]) -> Scene:
    """Return the scene with a change of every ball's state (n, 7); rolling balls roll."""
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
    """Return the state of every ball, (n, 7); without the spin of one that rolls."""
    spins = np.where(scene.rolls[:, np.newaxis], 0.0, scene.angular_velocities)
    return np.hstack([scene.positions[:, :2], scene.velocities[:, :2], spins])


@pytest.mark.parametrize("name", LAWS)
def test_changes_become_what_proofs_of_changed_shots_say(name: str) -> None:
    # Breaks where a sign, a factor or a term is wrong, and where growth is 30 times too large.
    scene = find_scene(name)
    growth = growth_of_proof(scene, certify(scene, motion=True))
    chance = np.random.default_rng(11)
    direction = chance.normal(size=(len(scene.balls), 7)) * np.abs(state(scene))
    direction[:, :2] = 0.01 * chance.normal(size=(len(scene.balls), 2))
    end = np.array([growth.t_end])
    largest = np.max(np.abs(growth.carry(direction[np.newaxis]).sample(end)))
    sides = [changed(scene, sign * CHANGE / largest * direction) for sign in (1.0, -1.0)]
    # The scenes hold rounded numbers: it is their own difference that is predicted from.
    real = (state(sides[0]) - state(sides[1]))[np.newaxis]
    predicted = growth.carry(real).sample(end)[0, 0]
    proofs = [certify(side) for side in sides]
    assert all(proof.proved for proof in proofs)
    ends = [np.array([[e.mid for e in place] for place in proof.positions]) for proof in proofs]
    difference = (ends[0] - ends[1]).astype(np.float64)
    assert difference == pytest.approx(predicted, abs=1e-5 * np.max(np.abs(predicted)))
    times = [
        np.array([float(one.t.mid - two.t.mid)])
        for one, two in zip(proofs[0].events, proofs[1].events, strict=True)
    ]
    shifts = growth.carry(real).event_shifts
    assert np.array(times) == pytest.approx(shifts, abs=1e-5 * np.max(np.abs(shifts)))


def test_rounding_displaces_a_rolling_ball_by_its_place_and_its_way() -> None:
    # x and vx are rounded once; y and vy are exactly 0 and stay so.
    scene = scene_of(ball((0.5, 0.0), (2.0, 0.0)), rolling_friction=0.02, table=None)
    growth = growth_of_proof(scene, certify(scene, motion=True))
    for t in (0.0, 1.5):
        assert growth.sizes([t])[0, 0] == pytest.approx(math.hypot(0.5 + R, 2.0 * t))


def test_what_rounding_does_is_the_sum_over_all_that_is_rounded() -> None:
    # The covariance against single changes: of a shot without an event, each number of each ball.
    scene = find_scene("half-ball-cut")
    growth = growth_of_proof(scene, certify(scene, motion=True))
    t = math.nextafter(growth.times[1], 0.0)
    x, y, vx, vy = state(scene)[0, :4]
    sizes = [abs(x) + R, abs(y) + R if vy else 0.0, abs(vx), abs(vy)]
    changes = np.zeros((4, 2, 7))
    for k, one in enumerate(sizes):
        changes[k, 0, k] = one
    moved = growth.carry(changes).sample(np.array([t]))[0, :, 0]
    assert growth.sizes([t])[0, 0] == pytest.approx(np.linalg.norm(moved))


def test_it_depends_on_no_order_of_the_balls() -> None:
    scene = find_scene("break-7")
    turned = scene.model_copy(update={"balls": scene.balls[::-1]})
    times = np.linspace(0.1, 9.0, 7)
    one, other = (growth_of_proof(s, certify(s, motion=True)).sizes(times) for s in (scene, turned))
    assert other[:, ::-1] == pytest.approx(one, rel=1e-6)


def test_the_horizon_is_where_the_size_passes_the_limit() -> None:
    scene = find_scene("chaos-a")
    growth = growth_of_proof(scene, certify(scene, motion=True))
    horizon = growth.horizon(1e-3, 2.0**-48)
    assert 0.0 < horizon < growth.t_end
    assert 2.0**-48 * np.max(growth.sizes([horizon - 1e-5])) <= 1e-3
    assert 2.0**-48 * np.max(growth.sizes([horizon + 1e-5])) > 1e-3
    assert growth.horizon(1e-6, 2.0**-48) < horizon
    assert growth.horizon(1e60, 2.0**-48) == math.inf


def test_there_is_no_derivative_past_two_collisions_at_one_instant() -> None:
    scene = find_scene("frozen-to-cushion")
    growth = growth_of_proof(scene, certify(scene, motion=True))
    assert 0.0 < growth.derivative_ends < growth.t_end
    assert np.isfinite(growth.sizes([math.nextafter(growth.derivative_ends, 0.0)])).all()
    assert np.isinf(growth.sizes([growth.derivative_ends])).any()
    assert growth.horizon(1e-3, 2.0**-48) == math.inf


@pytest.mark.parametrize("name", ["half-ball-cut", "draw-shot", "chaos-a", "frozen-to-cushion"])
def test_what_our_engine_says_of_itself_agrees(name: str) -> None:
    scene = find_scene(name)
    result, proof = simulate(scene, record="trajectory"), certify(scene, motion=True)
    assert own_words(result, proof) == []


def test_our_engines_sample_of_roundings_is_as_near_as_it_says() -> None:
    # Breaks where two roundings share their signs: of two balls that meet, their errors cancel;
    # of one ball, again and again in thousands of impacts, they add up.
    ratios = []
    for scene in (*map(random_shot, range(60)), find_scene("galperin-2"), find_scene("galperin-3")):
        result, proof = simulate(scene, record="trajectory"), certify(scene, motion=True)
        right = growth_of_proof(scene, proof).sizes([result.rest_time])[0]
        said = result.sensitivity([result.rest_time])[0]
        some = np.isfinite(right) & np.isfinite(said) & (right > 0.0)
        if proof.proved:
            ratios.append(said[some] / right[some])
    off = np.concatenate(ratios) - 1.0
    assert len(off) > 80
    assert np.sqrt(np.mean(off**2)) < 0.16
    assert np.abs(off).max() < 0.6


@pytest.mark.parametrize("factor", [30.0, 1000.0, 1.0 / 30.0])
def test_growth_that_an_engine_inflates_is_seen(
    factor: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = find_scene("half-ball-cut")
    result, proof = simulate(scene, record="trajectory"), certify(scene, motion=True)
    right = type(result.rounding).growth
    monkeypatch.setattr(type(result.rounding), "growth", lambda *a: factor * right(*a))
    assert any("`sensitivity` of ball" in fault for fault in own_words(replace(result), proof))


def test_a_horizon_that_an_engine_makes_up_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = find_scene("half-ball-cut")
    result, proof = simulate(scene, record="trajectory"), certify(scene, motion=True)
    monkeypatch.setattr(type(result), "horizon", lambda *_: 0.1)
    (fault,) = own_words(result, proof)
    assert fault.startswith("`horizon()` is 0.1 s")


@pytest.mark.parametrize("x", [0.3, 2.0])
def test_slopes_are_those_of_central_differences(x: float) -> None:
    def formula(x):
        y = 3.0 - x * x / 2 + 1.0 / x
        root = y.sqrt() if isinstance(y, Slope) else math.sqrt(y)
        power = (-x).exp() if isinstance(x, Slope) else math.exp(-x)
        return abs(-root) * power - (2.0 * x - 1.0) / (x + root)

    step = 1e-6
    found = formula(Slope(x, np.array([1.0])))
    assert float(found) == formula(x)
    difference = (formula(x + step) - formula(x - step)) / (2.0 * step)
    assert found.slope[0] == pytest.approx(difference, rel=1e-8)
