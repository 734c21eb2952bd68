"""Where a shot might have taken another course: by closed forms, and by making it do so."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from shots import R, ball, scene_of

from ghostball.engine import EventKind, ExactTrajectory, Scene, Table, simulate
from ghostball.validation.diagnose.predictability import bifurcations_of, nearest_of
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.truth.bifurcations import Bifurcation
from ghostball.validation.truth.passings import ball_passings, meetings_of


def found_in(scene: Scene) -> dict[str, Bifurcation]:
    result = simulate(scene, record="trajectory")
    return {one.kind: one for one in nearest_of(bifurcations_of(result))}


@pytest.mark.parametrize("depth", [1e-3, 1e-6, 1e-9])
def test_a_graze_is_as_deep_as_the_paths_overlap(depth):
    graze = found_in(scene_of(ball((0.0, 0.0), (1.0, 0.0)), ball((0.5, 2 * R - depth))))["graze"]
    assert graze.margin == pytest.approx(depth, rel=1e-6)
    assert (graze.a, graze.b) == (0, 1)
    # The scene's extent is what positions are changed by: the margin is used up by about its ratio.
    assert 0.1 < graze.relative * (0.5 + R) / depth < 10.0


@pytest.mark.parametrize("gap", [1e-3, 1e-6])
def test_a_near_miss_is_as_far_as_the_paths_are_apart(gap):
    miss = found_in(scene_of(ball((0.0, 0.0), (1.0, 0.0)), ball((0.5, 2 * R + gap))))["near miss"]
    assert miss.margin == pytest.approx(gap, rel=1e-6)
    mu, g, v = 0.02, 9.81, 1.0
    assert miss.t == pytest.approx((v - math.sqrt(v**2 - 2 * mu * g * 0.5)) / (mu * g), rel=1e-9)


def test_a_competitor_is_as_far_as_it_still_has_to_go():
    """Two balls ahead side by side, one 1e-6 m behind: it would have been met next."""
    behind = 1e-6
    scene = scene_of(
        ball((0.0, 0.0), (1.0, 0.0)), ball((0.5, R * 1.01)), ball((0.5 + behind, -R * 1.01))
    )
    order = found_in(scene)["order"]
    assert (order.a, order.b) == (0, 2)
    # Along the normal; the path that is left is longer by 1 / cos of 30 degrees or so.
    assert behind * 0.7 < order.margin < behind


def test_exact_ties_have_no_margin():
    tie = found_in(find_scene("three-ball-symmetric"))["tie"]
    assert (tie.margin, tie.relative) == (0.0, 0.0)
    assert "several collisions" in tie.describe(find_scene("three-ball-symmetric"))


def test_one_ball_on_an_unbounded_cloth_has_one_course():
    assert found_in(scene_of(ball((0.0, 0.0), (1.0, 0.5)))) == {}


def test_a_ball_that_stops_short_of_a_cushion_all_but_hits_it():
    mu, g, v, short = 0.02, 9.81, 1.0, 1e-6
    reach = v**2 / (2 * mu * g)
    table = Table(length=1.0 + reach + R + short, width=1.0)
    one = found_in(scene_of(ball((1.0, 0.5), (v, 0.0)), table=table))["near miss"]
    assert one.margin == pytest.approx(short, rel=1e-6)
    assert (one.a, one.b, one.t) == (0, -2, pytest.approx(v / (mu * g), rel=1e-9))
    assert "cushion right" in one.describe(scene_of(ball((1.0, 0.5), (v, 0.0)), table=table))


def test_a_ball_that_is_hit_away_from_a_cushion_all_but_hits_it():
    """A ball on its way to the left cushion meets another head-on, 1e-6 m short of it."""
    short = 1e-6
    gap = 2 * R + 2.0 * short  # both at one speed: each goes as far
    table = Table(length=3.0, width=1.0)
    scene = scene_of(
        ball((R + 2.0 * short, 0.5), (-1.0, 0.0)),
        ball((R + 2.0 * short + gap, 0.5), (-3.0, 0.0)),
        table=table,
    )
    found = found_in(scene)
    assert (found["order"].a, found["order"].b) == (0, -1)
    # The other gains 2 m/s on it, so that it goes 1e-6 m of its 2e-6 before they meet.
    assert found["order"].margin == pytest.approx(short, rel=1e-3)


def test_which_of_two_cushions_comes_first_is_another_order_and_no_other_course():
    assert "order" not in found_in(find_scene("corner-double-bounce"))


@pytest.mark.parametrize("name", ["break-7", "pool-break-9", "thin-cut"])
def test_the_course_holds_within_the_nearest_bifurcation_and_not_far_beyond(name):
    """Random changes of a tenth of it keep the sequence of collisions.

    Of ten times it, many don't: half of them make a grazing hit a fuller one.
    """
    scene = find_scene(name)
    result = simulate(scene, record="trajectory")
    nearest = nearest_of(bifurcations_of(result))[0].relative
    same = {
        factor: [
            _course(_shaken(scene, factor * nearest, seed)) == _course(scene) for seed in range(20)
        ]
        for factor in (0.1, 10.0)
    }
    assert sum(same[0.1]) >= 19
    assert sum(same[10.0]) <= 15


def _course(scene: Scene) -> list[tuple[int, int, int]]:
    events = simulate(scene, record="events").events
    kept = events[events["kind"] <= EventKind.BALL_CUSHION]
    return list(zip(kept["kind"].tolist(), kept["a"].tolist(), kept["b"].tolist(), strict=True))


def _shaken(scene: Scene, size: float, seed: int) -> Scene:
    """Return the scene with every position and velocity changed at random, relative to its size."""
    chance = np.random.default_rng(seed)
    extent = np.max(np.abs(scene.positions[:, :2])) + np.max(scene.radii)
    balls = []
    for one, position, velocity in zip(scene.balls, scene.positions, scene.velocities, strict=True):
        fields = one.model_dump(exclude_unset=True)
        shift = size * extent * chance.choice([-1.0, 1.0], 2)
        push = size * np.linalg.norm(velocity) * chance.choice([-1.0, 1.0], 2)
        fields["position"] = tuple((position[:2] + shift).tolist())
        fields["velocity"] = tuple((velocity[:2] + push).tolist())
        balls.append(fields)
    return Scene.model_validate({**scene.model_dump(by_alias=True), "balls": balls})


def test_a_ball_that_stops_short_of_another_all_but_hits_it():
    mu, g, v, short = 0.02, 9.81, 1.0, 1e-6
    reach = v**2 / (2 * mu * g)
    miss = found_in(scene_of(ball((0.0, 0.0), (v, 0.0)), ball((reach + 2 * R + short, 0.0))))
    assert miss["near miss"].margin == pytest.approx(short, rel=1e-6)


def naive_passings(result):
    """Search one pair of balls and one interval after the other, by the motion of the two alone."""
    motion, found = result.trajectory, []
    starts = [knots[:, 0] for knots in motion.knots]
    for i in range(len(starts)):
        for j in range(i):
            knots = (motion.knots[i], motion.knots[j])
            pair = ExactTrajectory(
                motion.radii[[i, j]], knots, motion.t_end, motion.spin_decelerations[[i, j]]
            )

            def closing(t, pair=pair):
                places, velocities, _ = pair.sample(np.array([t]))
                r, v = (values[0, 1] - values[0, 0] for values in (places, velocities))
                return r[0] * v[0] + r[1] * v[1]

            edges = np.unique(np.concatenate([starts[i], starts[j], [motion.t_end]])).tolist()
            meetings = meetings_of(result)[i, j]
            stops = []
            for start, end in itertools.pairwise(edges):
                low, high = start, end
                before = closing(math.nextafter(high, 0.0))
                if before < 0.0 <= closing(high) and high not in meetings:
                    stops.append(high)
                if not closing(low) < 0.0 < before:
                    continue
                for _ in range(60):
                    middle = 0.5 * (low + high)
                    low, high = (middle, high) if closing(middle) < 0.0 else (low, middle)
                found.append((high, i, j))
            found += [(t, i, j) for t in stops]
    return found


@pytest.mark.parametrize("name", ["break-7", "masse", "push"])
def test_passings_are_those_of_each_pair_alone_to_the_bit(name):
    # Breaks where pairs or intervals are mixed up, or a ball is moved by another of its rows.
    result = simulate(find_scene(name), record="trajectory")
    times, a, b, gaps = ball_passings(result)
    assert list(zip(times.tolist(), a.tolist(), b.tolist(), strict=True)) == naive_passings(result)
    places = result.sample(times).positions[..., :2]
    rows = np.arange(len(times))
    apart = np.linalg.norm(places[rows, a] - places[rows, b], axis=1)
    radii = result.scene.radii
    assert np.array_equal(gaps, np.maximum(apart - (radii[a] + radii[b]), 0.0))
