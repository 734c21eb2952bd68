"""The data of a replay: every engine, its events, and where a ball is lost or jumps."""

import json
from dataclasses import replace

import numpy as np
import pytest
from replay_decoder import decoded, place_at

from ghostball.engine import simulate
from ghostball.model import EVENT_DTYPE, Ball, Scene, Table
from ghostball.reports.page.replay_data import MAX_EVENTS, scene_data
from ghostball.reports.page.replay_tracks import FARTHEST, TOLERANCE
from ghostball.reports.shots import Run, Shot, load_shot
from ghostball.validation.results.records import Motion
from ghostball.validation.runs.sampling import motion_of
from ghostball.validation.scenes.library import find_scene


def motion_data(scene, motion, label="ghostball"):
    return scene_data(Shot(scene, (Run(label, None, motion),)))


def motion_of_path(times, xy, events=()) -> Motion:
    """Return a motion on the paths `xy`, (k, n, 2) [m], with the velocities of these paths."""
    xy = np.asarray(xy, dtype=float)
    k, n, _ = xy.shape
    positions = np.dstack([xy, np.full((k, n), 0.03)])
    with np.errstate(invalid="ignore"):
        velocities = np.gradient(positions, times, axis=0)
    nothing, spin = np.zeros(k), np.zeros_like(velocities)
    log = np.array(list(events), dtype=EVENT_DTYPE)
    return Motion(log, np.asarray(times), positions, velocities, spin, nothing, nothing, nothing)


def two_balls(**changes) -> Scene:
    balls = [
        Ball(id="cue", position=(0.5, 0.6), velocity=(1.0, 0.0)),
        Ball(id="object", position=(1.0, 0.628)),
    ]
    return Scene(
        **{"name": "cut", "table": Table(length=2.54, width=1.27), "balls": balls} | changes
    )


def test_a_scene_says_how_high_balls_fly():
    for name, high in (("flight-jump", 0.0734), ("draw-shot", 0.0)):
        scene = find_scene(name)
        data = motion_data(scene, motion_of(simulate(scene, record="trajectory")))
        assert data["highest"] == pytest.approx(high, abs=1e-3)


def test_event_times_are_exact():
    scene = find_scene("break-8")
    motion = motion_of(simulate(scene, record="trajectory"))
    (times, kinds, a, b), _ = decoded(motion_data(scene, motion))["ghostball"]
    assert times == motion.events["t"].tolist()
    assert kinds == motion.events["kind"].tolist()
    assert (a, b) == (motion.events["a"].tolist(), motion.events["b"].tolist())


def test_a_long_log_is_thinned_and_says_so():
    times = np.linspace(0.0, 1.0, 5 * MAX_EVENTS)
    xy = np.stack([times, 0 * times], axis=1)[:, None]
    motion = motion_of_path(times, xy, [(t, 1, 0, 0) for t in times])
    data = motion_data(two_balls(balls=two_balls().balls[:1]), motion)
    said = data["engines"][0]["motion"]
    assert (said["events"], said["of"]) == (MAX_EVENTS, len(times))
    (kept, *_), _ = decoded(data)["ghostball"]
    assert (kept[0], kept[-1], len(kept)) == (0.0, 1.0, MAX_EVENTS)


def test_a_ball_may_jump_at_an_instant():
    # Engines separate overlapping balls in an instant; no parabola contains both positions.
    before = np.nextafter(0.5, 0.0)
    times = np.array([0.0, 0.25, before, 0.5, 0.75, 1.0])
    x = np.where(times < 0.5, times, times + 0.003)
    motion = motion_of_path(times, np.stack([x, 0 * x], axis=1)[:, None], [(0.5, 0, 0, 1)])
    motion = replace(motion, velocities=np.ones_like(motion.velocities))
    _, (track,) = decoded(motion_data(two_balls(balls=two_balls().balls[:1]), motion))["ghostball"]
    assert place_at(track, 0.5, 1e-6)[0] == pytest.approx(0.503, abs=TOLERANCE)
    assert place_at(track, 0.4999, 1e-6)[0] == pytest.approx(0.4999, abs=TOLERANCE)


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 10 * FARTHEST])
def test_a_ball_without_a_finite_position_is_absent_from_there_on(wrong):
    times = np.linspace(0.0, 1.0, 11)
    xy = np.zeros((11, 2, 2))
    xy[:, :, 0] = times[:, None]
    xy[6:, 1, 1] = wrong
    motion = motion_of_path(times, xy)
    data = motion_data(two_balls(), motion)
    assert data["engines"][0]["motion"]["lost"] == [[1, times[6]]]
    json.dumps(data, allow_nan=False)
    _, (first, second) = decoded(data)["ghostball"]
    assert first["t"][-1] == pytest.approx(1.0)
    assert second["t"][-1] == pytest.approx(0.5)


def test_a_scene_holds_every_engine_that_was_asked_for(results):
    data = scene_data(load_shot(results, "head-on"), horizon=float("inf"))
    json.dumps(data, allow_nan=False)
    engines = {engine["label"]: engine for engine in data["engines"]}
    assert list(engines) == results.labels
    assert engines["pybullet"]["motion"] is None
    assert engines["pybullet"]["reason"] == "no table | with legs"
    assert engines["newcomer:dt=1e-3"]["outcome"] == "failed"
    assert engines["ghostball"]["ours"]
    assert data["horizon"] is None
    assert data["truth"]["rest"][0] == pytest.approx([1.2, 0.635])
    looks = {(e["colour"], tuple(e["dash"]), e["marker"]) for e in data["engines"]}
    assert len(looks) == len(engines)  # all looks are different


def test_what_an_engine_lost_far_off_leaves_the_view_on_the_table():
    times = np.linspace(0.0, 1.0, 11)
    xy = np.zeros((11, 2, 2))
    xy[:, 1, 0] = 900.0 * times
    own = motion_data(two_balls(), motion_of_path(times, 0 * xy + 0.5), label="ghostball")
    lost = motion_data(two_balls(), motion_of_path(times, xy), label="pymunk")
    assert own["view"][1] < 3.0
    cloth = motion_data(two_balls(table=None), motion_of_path(times, xy), label="pymunk")
    assert cloth["view"][1] < 5.0
    assert lost["view"][1] < 3.0
