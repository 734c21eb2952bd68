"""Perturbed initial states are reproducible, within their size, and without overlaps."""

import hashlib
import math

import numpy as np
import pytest

from ghostball.model import Ball, Physics, Scene, Table
from ghostball.validation.scenes.library import find_scene, select
from ghostball.validation.suite.ensemble import Ensemble, EnsembleError, PerturbationSize, varied

SIZE = PerturbationSize()
ROUNDING = 1e-15


def gaps(scene: Scene) -> np.ndarray:
    """Return the gaps of all pairs, (n (n - 1) / 2,) [m]."""
    centres = scene.positions[:, : 3 if scene.physics.airborne else 2]
    i, j = np.triu_indices(len(centres), 1)
    return np.linalg.norm(centres[i] - centres[j], axis=1) - (scene.radii[i] + scene.radii[j])


@pytest.mark.parametrize("scene", select(), ids=lambda scene: scene.name)
def test_every_shipped_scene_is_perturbed_within_its_size_and_nothing_overlaps(scene: Scene):
    radii, table = scene.radii, scene.table
    for k in range(6):
        member = varied(scene, SIZE, k)
        moved = member.positions - scene.positions
        assert np.abs(moved[:, :2]).max() <= SIZE.position + ROUNDING
        assert not moved[:, 2].any()
        assert np.all(gaps(member) > np.minimum(gaps(scene), 0.0) - ROUNDING)
        if table is not None:
            x, y = member.positions[:, 0], member.positions[:, 1]
            sides = {
                "left": x - radii,
                "right": table.length - radii - x,
                "bottom": y - radii,
                "top": table.width - radii - y,
            }
            assert min(sides[name].min() for name in table.cushions) >= -ROUNDING
        before, after = scene.velocities, member.velocities
        speeds = np.linalg.norm(before, axis=1)
        change = np.linalg.norm(after - before, axis=1)
        assert np.all(change <= 1.001 * math.sqrt(2.0) * SIZE.velocity * speeds)
        assert np.array_equal(change > 0.0, speeds > 0.0)
        assert np.array_equal(member.rolls, scene.rolls)  # a rounded rotation would cause slip
        assert member.physics == scene.physics
        assert member.t_max == scene.t_max


@pytest.mark.parametrize("name", ["frozen-break", "frozen-triangle", "push-line", "cradle"])
def test_of_frozen_balls_every_contact_opens(name):
    scene = find_scene(name)
    touching = gaps(scene) < 1e-9
    assert touching.any()
    opened = np.array([gaps(varied(scene, SIZE, k))[touching] for k in range(30)])
    assert opened.min() > 0.0
    # Fails if balls deep in the rack aren't moved: their gaps would be a hundredth of this.
    assert opened.mean() > 0.25 * SIZE.position


def test_members_depend_on_scene_name_and_number_alone():
    scene = find_scene("chaos-a")
    members = [varied(scene, SIZE, k) for k in range(4)]
    assert members[2] == varied(scene, SIZE, 2)  # independent of earlier members
    starts = {tuple(member.positions.ravel()) for member in members}
    starts.add(tuple(varied(scene.model_copy(update={"name": "b"}), SIZE, 0).positions.ravel()))
    assert len(starts) == 5


def test_members_are_the_same_on_every_machine():
    """Compare with a stored hash: if it changes, ensembles of two versions have different shots."""
    digest = hashlib.sha256()
    for name in ("chaos-a", "frozen-triangle"):
        member = varied(find_scene(name), SIZE, 3)
        digest.update(member.positions.tobytes() + member.velocities.tobytes())
    assert digest.hexdigest() == "2e4d5cd1071b6dae9d68207f7dfa8a3503574cf1c4621e586c8432dd5a9e2eab"


def test_numbers_fill_the_stated_size_evenly():
    scene = Scene(name="two", balls=[Ball(id="a", position=(0, 0), velocity=(2.0, 0.0))])
    members = [varied(scene, PerturbationSize(velocity=0.05, position=1e-3), k) for k in range(400)]
    x = np.array([member.positions[0, 0] for member in members]) / 1e-3
    speed = np.array([member.balls[0].speed for member in members]) / 2.0 - 1.0
    angle = np.array([math.atan2(*member.velocities[0, 1::-1]) for member in members])
    for values in (x, speed / 0.05, angle / 0.05):
        assert np.abs(values).max() <= 1.0 + 1e-12
        # The limit of the Kolmogorov-Smirnov test at a probability of 0.001 is 1.95 / sqrt(400).
        ranks = (np.arange(400) + 0.5) / 400
        assert np.abs(np.sort(0.5 * (values + 1.0)) - ranks).max() < 1.95 / 20.0


def test_spin_is_turned_and_scaled_with_the_velocity():
    spin = (3.0, 40.0, -7.0)
    scene = Scene(
        name="masse",
        physics=Physics(motion="sliding"),
        balls=[Ball(id="a", position=(0, 0), velocity=(2.0, 0.0), angular_velocity=spin)],
    )
    ball = varied(scene, PerturbationSize(velocity=0.1), 1).balls[0]
    assert ball.angular_velocity is not None
    factor = ball.speed / 2.0
    turn = math.atan2(ball.velocity[1], ball.velocity[0])
    x, y, z = ball.angular_velocity
    assert z == pytest.approx(factor * spin[2], rel=1e-14)
    assert math.hypot(x, y) == pytest.approx(factor * math.hypot(*spin[:2]), rel=1e-14)
    assert math.atan2(y, x) == pytest.approx(math.atan2(spin[1], spin[0]) + turn, rel=1e-13)


def test_a_ball_that_is_struck_is_scaled_and_turned_as_one_that_moves():
    strike = {"speed": 2.0, "direction": 0.3, "offset_left": 0.2}
    balls = [Ball(id="a", position=(0, 0), strike=strike), Ball(id="b", position=(1, 0))]
    scene = Scene(name="struck", physics=Physics(motion="sliding"), balls=balls)
    member = varied(scene, PerturbationSize(velocity=0.1), 1)
    assert member == varied(scene.without_strikes(), PerturbationSize(velocity=0.1), 1)
    assert member.balls[0].strike is None
    assert member.balls[0].velocity != scene.balls[0].velocity


def test_a_ball_without_room_stays_where_it_is():
    balls = [Ball(id="a", position=(0.5, 0.028575)), Ball(id="b", position=(0.3, 0.028575))]
    scene = Scene(name="slot", table=Table(length=1.0, width=0.05715), balls=balls)
    assert varied(scene, SIZE, 0).positions.tolist() == scene.positions.tolist()


@pytest.mark.parametrize("only", [PerturbationSize(velocity=0.0), PerturbationSize(position=0.0)])
def test_either_part_of_the_size_may_be_zero(only: PerturbationSize):
    scene = find_scene("chaos-a")
    member = varied(scene, only, 0)
    assert (member.positions == scene.positions).all() == (only.position == 0.0)
    assert (member.velocities == scene.velocities).all() == (only.velocity == 0.0)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("velocity=-1e-3", "`velocity` must be greater than or equal to 0, got '-1e-3'"),
        ("position=nan", "`position` must be a finite number, got 'nan'"),
        ("position=inf", "`position` must be a finite number, got 'inf'"),
        ("velocity=0.2", "`velocity` must be less than or equal to 0.1"),
        ("velocity=0,position=0", "must not be 0 in both velocity and position"),
        ("velocty=1e-3", "`velocty` is not a known field. Did you mean `velocity`?"),
        ("velocity=", "`velocity` must be a valid number"),
        ("velocity", "must give each number once, by its name, got 'velocity'"),
        ("velocity=1e-3,velocity=1e-3", "must give each number once, by its name"),
        ("", "Write it as velocity=1e-3,position=1e-4"),
    ],
)
def test_a_wrong_size_is_refused(text, said):
    with pytest.raises(EnsembleError, match="size") as refused:
        PerturbationSize.parse(text)
    assert said in str(refused.value)


def test_a_size_is_read_as_it_is_written():
    assert PerturbationSize.parse("position=2e-4") == PerturbationSize(position=2e-4)
    assert PerturbationSize.parse(
        str(PerturbationSize(velocity=0.01, position=1e-5))
    ) == PerturbationSize(velocity=0.01, position=1e-5)


def test_what_no_member_can_be_made_of_is_refused():
    with pytest.raises(EnsembleError, match=r'0.00714375 m in scene "stop", got 0.01 m'):
        varied(find_scene("stop"), PerturbationSize(position=0.01), 0)
    with pytest.raises(EnsembleError, match="`index` of a member must be at least 0, got -1"):
        varied(find_scene("stop"), SIZE, -1)


def test_an_ensemble_is_of_two_starts_at_least_each_with_a_name_of_its_own():
    members = Ensemble(3, SIZE).of(find_scene("stop"))
    assert [one.name for one in members] == ["stop.varied-1", "stop.varied-2", "stop.varied-3"]
    with pytest.raises(EnsembleError, match="at least 2 members, got 1"):
        Ensemble(1)
    long = find_scene("stop").model_copy(update={"name": "s" * 64})
    assert len(varied(long, SIZE, 998).name) <= 64
