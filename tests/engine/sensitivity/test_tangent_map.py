"""The tangent map: what small changes become, by closed forms, by differences, and by proof."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import numpy as np
import pytest
from same.images import shuffled
from shots import R, ball, scene_of

from ghostball.engine import simulate
from ghostball.engine.compilation import kernels_of
from ghostball.engine.sensitivity import QUALITY, ROUNDING, tangent_map, tangent_of
from ghostball.model import EventKind, GhostballError, Scene, partner_name
from ghostball.validation.scenes.library import find_scene

G = 9.81
MU = 0.02

TWO = np.ones((1, 2, 7))
"""A change of two balls."""


def recorded(scene: Scene):
    return simulate(scene, record="trajectory")


def one_direction(n: int, **parts: tuple[float, ...]) -> np.ndarray:
    """Return a change of the first ball: r, v or w."""
    direction = np.zeros((1, n, 7))
    for name, place in (("r", slice(0, 2)), ("v", slice(2, 4)), ("w", slice(4, 7))):
        if name in parts:
            direction[0, 0, place] = parts[name]
    return direction


def moved(scene: Scene, change: np.ndarray) -> Scene:
    """Return the scene with the change of every ball's state (n, 7) added; rolling balls roll."""
    balls = []
    for one, rolls, d in zip(scene.balls, scene.rolls, change, strict=True):
        position = np.add(one.position[:2], d[:2])
        velocity = np.add(one.velocity[:2], d[2:4])
        update = {"position": tuple(position), "velocity": tuple(velocity)}
        if not rolls:
            update["angular_velocity"] = tuple(np.add(one.angular_velocity, d[4:]))
        balls.append({**one.model_dump(exclude_none=True), **update})
    return Scene.model_validate({**scene.model_dump(by_alias=True), "balls": balls})


def test_a_rolling_ball_is_displaced_as_its_closed_form_says():
    """dr = dr0 + [t - (mu g t^2 / 2 |v0|) P] dv0 while it rolls, P across the velocity."""
    result = recorded(scene_of(ball((0.5, 0.5), (1.0, 0.0)), rolling_friction=MU, table=None))
    along, across = result.tangent(
        np.concatenate([one_direction(1, v=(1.0, 0.0)), one_direction(1, v=(0.0, 1.0))])
    ).sample([1.5])[0]
    t = 1.5
    assert along[0, :2] == pytest.approx([t, 0.0], rel=1e-14)
    assert across[0, :2] == pytest.approx([0.0, t - MU * G * t**2 / 2.0], rel=1e-14)


def test_where_a_rolling_ball_rests_moves_as_its_closed_form_says():
    """At rest dr = dr0 + (v0 / mu g) (v^ v^T + P / 2) dv0."""
    result = recorded(scene_of(ball((0.5, 0.5), (1.0, 0.0)), rolling_friction=MU, table=None))
    along, across = result.tangent(
        np.concatenate([one_direction(1, v=(1.0, 0.0)), one_direction(1, v=(0.0, 1.0))])
    ).sample([result.rest_time])[0]
    reach = 1.0 / (MU * G)
    assert along[0] == pytest.approx([reach, 0, 0, 0, 0, 0, 0], rel=1e-14, abs=1e-14)
    assert across[0] == pytest.approx([0, reach / 2, 0, 0, 0, 0, 0], rel=1e-14, abs=1e-14)


def test_a_slide_ends_with_the_velocity_that_its_slip_leaves():
    """dv_f = dv0 - (2/7) du0, whatever the friction (at the instant at which it ends)."""
    scene = scene_of(
        ball((0.5, 0.5), (2.0, 0.3), angular_velocity=(1.0, -20.0, 3.0)),
        motion="sliding",
        table=None,
        rolling_friction=0.0,
        t_max=5.0,
    )
    result = recorded(scene)
    t = float(result.events["t"][0]) if len(result.events) else math.inf
    change = np.array([0.0, 0.0, 0.4, -0.3, 5.0, 7.0, 1.0])
    (after,) = result.tangent(change[np.newaxis, np.newaxis]).sample([t + 0.1])[0]
    slip = change[2:4] + R * np.array([-change[5], change[4]])
    assert after[0, 2:4] == pytest.approx(change[2:4] - slip * 2.0 / 7.0, rel=1e-12)


SCENES = (
    "around-the-table",
    "break-16",
    "draw-shot",
    "masse",
    "moving-moving",
    "pool-break-9",
    "mathavan-cut",
    "restitution-cut",
    "throw-alciatore",
    "throw-slip",
    "throw-stick",
    "unequal-balls",
)


@pytest.mark.parametrize("name", SCENES)
def test_derivatives_agree_with_central_differences(name):
    """Of the engine's own shots, at instants all over the shot, for changes of every ball."""
    _check_derivatives(find_scene(name))


def test_derivatives_through_a_restitution_that_falls_with_speed():
    scene = find_scene("three-cushions")
    physics = scene.physics.model_copy(update={"rolling_friction_quadratic": 0.0})
    _check_derivatives(scene.model_copy(update={"physics": physics}))


ELL = [[0, 0], [2, 0], [2, 0.8], [1.1, 0.9], [1.0, 1.7], [0, 1.6]]


@pytest.mark.parametrize(
    ("table", "position", "velocity", "met"),
    [
        pytest.param("wpa-9ft", (0.6, 0.635), (3.7, -1.6), {"bottom", "top", "right"}, id="jaws"),
        pytest.param("wpa-9ft", (0.6, 0.635), (1.3, -1.14), {"bottom"}, id="pocketed"),
        pytest.param({"vertices": ELL}, (1.6, 0.4), (-1.2, 1.2), {"side-3"}, id="corner"),
        pytest.param(
            {"length": 2, "width": 1, "posts": [{"centre": (1, 0.5), "radius": 0.1}]},
            (0.3, 0.45),
            (2.0, 0.1),
            {"post-1"},
            id="post",
        ),
    ],
)
@pytest.mark.parametrize("cushion", ["restitution", "han2005"])
def test_derivatives_through_what_is_not_a_line(table, position, velocity, met, cushion):
    """A jaw, a corner that points into the table and a post turn the normal; a hole ends it all."""
    scene = scene_of(
        ball(position, velocity, angular_velocity=(3.0, -5.0, 20.0)),
        table=table,
        motion="sliding",
        cushion=cushion,
    )
    result = recorded(scene)
    named = {partner_name(EventKind(e["kind"]), e["b"]) for e in result.events if e["b"] >= 0}
    assert met <= named
    _check_derivatives(scene)


def _check_derivatives(scene: Scene) -> None:
    result = recorded(scene)
    times = np.linspace(0.05, 0.95, 7) * result.rest_time
    for change in _directions(result.scene, 3):
        after, before, predicted = _both_sides(result, change, times)
        difference = recorded(after).sample(times).positions
        difference -= recorded(before).sample(times).positions
        error = np.max(np.abs(difference[..., :2] - predicted[..., :2]), axis=(1, 2))
        rounding = 2 * QUALITY * ROUNDING * np.max(result.sensitivity(times), axis=1)
        assert np.all(error < 1e-5 * np.max(np.abs(predicted), axis=(1, 2)) + rounding)


def _both_sides(result, change, times):
    """Return the scene changed by much less than matters and by the opposite, and what the tangent
    map makes of their difference at `times`, (k, n, 7).

    The scenes hold rounded numbers: it is their own difference that is predicted from.
    """
    (largest,) = np.max(np.abs(result.tangent(change[np.newaxis]).sample(times)), axis=(0, 2, 3))
    size = 1e-7 / largest
    after, before = (moved(result.scene, sign * size * change) for sign in (1, -1))
    real = np.hstack(
        [
            (after.positions - before.positions)[:, :2],
            (after.velocities - before.velocities)[:, :2],
            after.angular_velocities - before.angular_velocities,
        ]
    )
    real[result.scene.rolls, 4:] = 0.0
    return after, before, result.tangent(real[np.newaxis]).sample(times)[:, 0]


def _directions(scene: Scene, count: int) -> np.ndarray:
    """Return random changes of the balls that move, of rolling ones without their spin."""
    generator = np.random.default_rng(7)
    n = len(scene.balls)
    directions = np.zeros((count, n, 7))
    moving = np.any(scene.velocities != 0.0, axis=1)
    directions[:, :, :2] = 0.01 * generator.normal(size=(count, n, 2))
    directions[:, moving, 2:4] = generator.normal(size=(count, int(moving.sum()), 2))
    free = moving & ~scene.rolls
    directions[:, free, 4:] = 10.0 * generator.normal(size=(count, int(free.sum()), 3))
    return directions


def test_event_shifts_say_when_events_come():
    scene = find_scene("break-7")
    result = recorded(scene)
    change, size = _directions(scene, 1), 1e-8
    shifts = result.tangent(change).event_shifts[:, 0]
    after, before = (recorded(moved(scene, sign * size * change[0])) for sign in (1, -1))
    difference = (after.events["t"] - before.events["t"]) / (2 * size)
    assert difference == pytest.approx(shifts, rel=1e-4, abs=1e-4 * np.max(np.abs(shifts)))


@pytest.mark.parametrize("name", ["break-7", "half-ball-cut", "throw-slip", "moving-moving"])
def test_the_numbering_of_the_balls_does_not_matter(name):
    """Breaks where the signs of roundings are those of a row of the log, or of a ball's number."""
    result = recorded(find_scene(name))
    order = list(range(len(result.scene.balls)))
    times = np.linspace(0.0, 1.0, 9) * result.rest_time
    base = result.sensitivity(times)
    for seed in range(3):
        random.Random(seed).shuffle(order)
        other = recorded(shuffled(result.scene, order))
        assert np.array_equal(other.rest_positions, result.rest_positions[order])
        assert other.sensitivity(times) == pytest.approx(base[:, order], rel=1e-9)
        assert other.horizon() == pytest.approx(result.horizon(), rel=1e-9)


def test_what_was_recorded_must_be_of_the_scene():
    one, two = recorded(find_scene("stop")), recorded(find_scene("half-ball-cut"))
    with pytest.raises(GhostballError, match="must be those of the scene, of 2 balls"):
        tangent_of(two.scene, one.trajectory, one.events, np.ones((1, 2, 7)))
    events = two.events.copy()
    events["a"][0] = 99
    with pytest.raises(GhostballError, match="99"):
        tangent_of(two.scene, two.trajectory, events, np.ones((1, 2, 7)))


def test_events_at_obstacles_must_be_of_the_scene():
    """Compiled kernels would read the obstacle before the first one."""
    with_table = recorded(find_scene("wall-bounce"))
    assert EventKind.BALL_CUSHION in with_table.events["kind"]
    free = with_table.scene.model_copy(update={"table": None})
    one = np.ones((1, len(free.balls), 7))
    with pytest.raises(GhostballError, match=r"whose obstacles are \[\], got events at obstacles"):
        tangent_of(free, with_table.trajectory, with_table.events, one)
    events = with_table.events.copy()
    events["b"][events["kind"] == EventKind.BALL_CUSHION] = 7
    with pytest.raises(GhostballError, match=r"obstacles are \[0, 1, 2, 3\], got .* \[7\]"):
        tangent_of(with_table.scene, with_table.trajectory, events, one)


def test_a_trajectory_must_be_of_the_scene():
    """One in air has more columns, and a ball without any segment would take another's."""
    air, shot = recorded(find_scene("air-rolls")), recorded(find_scene("half-ball-cut"))
    plain = air.scene.physics.model_copy(
        update={"air_drag": 0.0, "rolling_friction_quadratic": 0.0}
    )
    scene = air.scene.model_copy(update={"physics": plain})
    one = np.ones((1, len(scene.balls), 7))
    with pytest.raises(GhostballError, match="with 14 numbers for each segment"):
        tangent_of(scene, air.trajectory, air.events, one)
    empty = replace(shot.trajectory, segments=(shot.trajectory.segments[0], np.empty((0, 14))))
    with pytest.raises(GhostballError, match=r"got arrays of shapes \[\(0, 14\)"):
        tangent_of(shot.scene, empty, shot.events, TWO)


@pytest.mark.parametrize("name", ["air-rolls", "flight-jump"])
def test_where_nothing_is_known_nothing_is_compiled(name, monkeypatch):
    """In air and in flight all derivatives are infinite, without a kernel that says so."""
    result = recorded(find_scene(name))
    for kernel in ("run_tangent", "sample_tangent", "sample_growth", "warm_up"):
        monkeypatch.setattr(f"{tangent_map.__name__}.{kernel}", None)
    n, m = len(result.scene.balls), len(result.events)
    assert np.all(np.isinf(result.sensitivity([0.0, 0.1])))
    assert result.horizon() == 0.0
    tangent = result.tangent(np.ones((3, n, 7)))
    assert tangent.sample([0.0, 0.1]).shape == (2, 3, n, 7)
    assert not np.isfinite(tangent.sample([0.0, 0.1])).any()
    assert tangent.event_shifts.shape == (m, 3)
    assert np.isnan(tangent.event_shifts).all()
    assert kernels_of([result.scene], tangents=True) == kernels_of([result.scene])


def test_what_is_exact_by_symmetry_is_not_taken_for_chaos():
    """Galperin's balls stay on their line to the last bit: rounding never leaves it."""
    result = recorded(find_scene("galperin-2"))
    assert result.horizon() == math.inf
    assert np.max(result.sensitivity(result.rest_time)) < 1e9


def test_nothing_is_predicted_past_several_collisions_of_one_ball():
    result = recorded(find_scene("three-ball-symmetric"))
    t = float(result.events["t"][0])
    assert result.horizon() == pytest.approx(t)
    assert np.all(np.isfinite(result.sensitivity(t * (1 - 1e-9))))
    assert np.all(np.isinf(result.sensitivity(t * (1 + 1e-9))))


def test_nothing_is_predicted_past_sustained_contact():
    result = recorded(find_scene("push-line"))
    assert result.horizon() < result.rest_time
    assert np.any(np.isinf(result.sensitivity(result.rest_time)))


def test_horizon_is_where_the_error_passes_the_tolerance():
    result = recorded(find_scene("chaos-a"))
    horizon = result.horizon(tolerance=1e-3)
    assert 0.0 < horizon < result.rest_time

    def error(t):
        return QUALITY * ROUNDING * np.max(result.sensitivity(t))

    assert error(horizon) >= 1e-3 >= error(horizon * (1 - 1e-12))
    assert result.horizon(tolerance=1e-6) < horizon < result.horizon(tolerance=1.0)
    assert result.horizon(error=1e-9) < horizon
    assert result.horizon(tolerance=1e12) == math.inf


@pytest.mark.parametrize("tolerance", [0.0, -1.0, math.nan, math.inf])
def test_a_tolerance_must_be_a_positive_number(tolerance):
    with pytest.raises(GhostballError, match="`tolerance` must be a positive number"):
        recorded(find_scene("stop")).horizon(tolerance)


@pytest.mark.parametrize(
    ("directions", "message"),
    [
        (np.zeros((1, 2, 7)), r"shape \(m, 1, 7\)"),
        (np.zeros((0, 1, 7)), "m at least 1"),
        (np.zeros(7), r"got \(7,\)"),
        (np.full((1, 1, 7), np.nan), "must be finite"),
    ],
)
def test_directions_are_checked(directions, message):
    with pytest.raises(GhostballError, match=message):
        recorded(find_scene("stop")).tangent(directions)


def test_a_run_that_recorded_nothing_has_no_sensitivity():
    with pytest.raises(GhostballError, match='record="trajectory"'):
        simulate(find_scene("stop")).sensitivity(1.0)


def test_an_engine_that_records_frames_has_no_sensitivity():
    from ghostball.reference_adapters import make_engine

    result = make_engine("paper-discrete").simulate(find_scene("stop"), record="trajectory")
    with pytest.raises(GhostballError, match="records frames"):
        result.horizon()


def test_side_spin_that_nothing_brakes_stays():
    """Breaks where a spin of 0 counts as one that the cloth has ended."""
    scene = scene_of(
        ball((0.3, 0.5), (1.0, 0.0)),
        ball((0.6, 0.5)),
        motion="sliding",
        ball_friction=0.06,
        spinning_friction_rate=0.0,
    )
    result = recorded(scene)
    (spun,) = result.tangent(one_direction(2, w=(0.0, 0.0, 1.0))).sample([0.1])[0]
    assert spun[0, 6] == 1.0
    step = 1e-7
    sides = [moved(scene, s * step * one_direction(2, r=(0.0, 1.0))[0]) for s in (1, -1)]
    after, before = (recorded(side).sample([1.0]).angular_velocities[0, 1, 2] for side in sides)
    (aside,) = result.tangent(one_direction(2, r=(0.0, 1.0))).sample([1.0])[0]
    assert aside[1, 6] == pytest.approx((after - before) / (2 * step), rel=1e-4)
    assert abs(aside[1, 6]) > 10.0
