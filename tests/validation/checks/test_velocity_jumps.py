"""The velocity of a ball jumps only at contacts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from wrong_runs import events_in, frames_of, right, stops_late, with_events, with_frames

from ghostball.model import EventKind, Result, first_energy
from ghostball.reference_adapters import make_engine
from ghostball.reference_adapters.base import resolution_of
from ghostball.validation.checks.accuracy import BROKEN_SHARE, accuracy_of
from ghostball.validation.checks.velocity_jumps import largest_jump
from ghostball.validation.runs.engine_runs import run_ours
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.truth.scene_truth import truth_of


def share_of(result: Result, resolution: float = 0.0) -> float:
    """Return the energy of the largest jump over the initial energy."""
    return largest_jump(result, resolution) / first_energy(result.scene)


@pytest.mark.parametrize(
    "name", ["half-ball-cut", "draw-shot", "frozen-triangle", "wedged", "pocket-bank", "rail-along"]
)
def test_a_right_motion_has_no_jump(name: str) -> None:
    scene = find_scene(name)
    assert share_of(run_ours(scene)) < 1e-20
    assert share_of(right(scene)) < 1e-20
    for label in ("pymunk", "pymunk:dt=1e-2", "pymunk:contact_steps=exact"):
        engine = pytest.importorskip("pymunk") and make_engine(label)
        run = engine.simulate(scene, record="trajectory")
        assert share_of(run, resolution_of(engine, scene)) < 1e-3 * BROKEN_SHARE, label


@pytest.mark.parametrize("resolution", [0.0, 2e-3])
@pytest.mark.parametrize("name", ["half-ball-cut", "frozen-triangle", "push-line"])
def test_balls_that_stop_dead_with_nothing_near_them_jump(name: str, resolution: float) -> None:
    scene = find_scene(name)
    stopped = stops_late(scene)
    assert share_of(stopped, resolution) > BROKEN_SHARE
    # The jump is also detected if the balls move in the last sample, and the run claims that they
    # rest.
    frames = frames_of(stopped)
    velocities = frames.velocities.copy()
    velocities[-1] = velocities[-2]
    assert share_of(with_frames(stopped, velocities=velocities), resolution) > BROKEN_SHARE
    found = accuracy_of(stopped, truth_of(scene), resolution=resolution)
    assert found is not None
    assert (found.kind, found.cause) == ("broken", "jump")
    assert found.sentence.startswith("unphysical: velocities jump without a contact (0.")


def test_a_ball_may_stop_where_it_touches_something_but_not_where_it_only_says_so() -> None:
    scene = find_scene("half-ball-cut")
    stopped = stops_late(scene)
    end = stopped.rest_time
    for kind, other in (
        (EventKind.BALL_BALL, 1),
        (EventKind.BALL_CUSHION, 0),
        (EventKind.POCKETED, 0),
        (EventKind.BALL_CLOTH, -1),
        (EventKind.ROLL_TO_REST, -1),
    ):
        balls = (0,) if kind is EventKind.BALL_BALL else range(len(scene.balls))
        rows = [(end, kind, ball, other) for ball in balls]
        added = np.array(rows, dtype=events_in(stopped).dtype)
        said = with_events(stopped, np.concatenate([events_in(stopped), added]))
        for resolution in (0.0, 2e-3):
            assert share_of(said, resolution) > BROKEN_SHARE, kind
    positions = frames_of(stopped).positions.copy()
    way = positions[-1, 1] - positions[-1, 0]
    positions[-1, 1] = positions[-1, 0] + 2.0 * scene.balls[0].radius * way / np.linalg.norm(way)
    assert share_of(with_frames(stopped, positions=positions)) < 1e-20


def test_a_report_explains_a_change_that_the_motion_shows_a_step_away() -> None:
    """The velocities change a step after the reported event, when the balls are this far apart."""
    scene = find_scene("half-ball-cut")
    run = right(scene)
    events, frames = events_in(run), frames_of(run)
    hit = float(events["t"][events["kind"] == EventKind.BALL_BALL][0])
    k = int(np.searchsorted(frames.times, hit))
    late = 0.01
    positions, velocities = frames.positions.copy(), frames.velocities.copy()
    normal = positions[k, 1] - positions[k, 0]
    touching = scene.radii[0] + scene.radii[1]
    positions[k - 1 : k + 2, 1] = positions[k - 1 : k + 2, 0] + (
        (touching + 2.5 * late) * normal / np.linalg.norm(normal)
    )
    shown = with_frames(run, positions=positions, velocities=velocities)
    assert share_of(shown, late) < 1e-3 * BROKEN_SHARE


def test_a_run_that_ends_as_balls_move_stops_none() -> None:
    run = right(find_scene("half-ball-cut"))
    frames = frames_of(run)
    half = len(frames.times) // 2
    parts = (frames.positions, frames.velocities, frames.angular_velocities)
    motion = type(frames)(frames.times[:half], *(part[:half] for part in parts))
    ended = replace(run, trajectory=motion, rest_time=motion.t_end)
    assert share_of(ended) > BROKEN_SHARE
    assert share_of(replace(ended, status=type(run.status).T_MAX)) < 1e-20
