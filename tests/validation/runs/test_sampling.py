"""Sample times of stored motions, and overlaps in exact motions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.engine.impacts.hertz import deepest_overlap, stiffness
from ghostball.model import Ball, Phase, Physics, SampledTrajectory, Scene
from ghostball.reference_adapters import make_engine
from ghostball.validation.runs.sampling import (
    MAX_TIMES,
    PATH_DEVIATION,
    deepest_contact,
    energy_series,
    largest_overlap,
    momentum_series,
    motion_of,
    times_gone,
    union_times,
)

SHOT = Scene(
    name="shot",
    balls=[
        Ball(id="a", position=(0.0, 0.0), velocity=(1.0, 0.0)),
        Ball(id="b", position=(0.5, 0.02)),
    ],
)


def test_too_many_events_are_thinned_evenly_and_the_grid_stays() -> None:
    events = np.linspace(0.0, 1.0, 10_001)
    times = union_times(1.0, events, uniform=11, limit=60)
    assert len(times) <= 60
    assert set(np.linspace(0.0, 1.0, 11)) <= set(times)
    assert np.max(np.diff(times)) < 0.03  # 49 events, 1/48 s apart: no gap is larger


def test_an_event_brings_the_instant_before_it_and_both_are_thinned_together() -> None:
    times = union_times(1.0, np.array([0.0, 0.25, 0.6]), uniform=3, limit=100, before=True)
    assert times.tolist() == [
        0.0,
        np.nextafter(0.25, 0.0),
        0.25,
        0.5,
        np.nextafter(0.6, 0.0),
        0.6,
        1.0,
    ]
    many = union_times(1.0, np.linspace(0.0, 1.0, 10_001), uniform=11, limit=60, before=True)
    assert len(many) <= 60
    pairs = np.diff(many) <= np.spacing(many[1:])
    assert np.count_nonzero(pairs) >= 23  # 24 events; no time comes before the event at 0


def test_a_stored_motion_shows_the_overlap_that_the_engine_undid() -> None:
    # Fails if only the state after an event is stored, because the paper's algorithm separates the
    # balls then.
    result = make_engine("paper-discrete").simulate(SHOT, record="trajectory")
    motion = motion_of(result)
    gap = np.linalg.norm(motion.positions[:, 0] - motion.positions[:, 1], axis=1) - 2 * 0.028575
    largest = largest_overlap(result)
    assert largest > 1e-3
    assert -gap.min() == pytest.approx(largest, rel=1e-9)


def test_a_stored_motion_holds_every_event() -> None:
    result = simulate(SHOT, record="trajectory")
    motion = motion_of(result)
    assert set(motion.events["t"]) <= set(motion.times)
    assert len(motion.times) <= MAX_TIMES
    assert np.all(np.diff(motion.times) > 0)
    assert np.array_equal(motion.positions[-1], result.rest_positions)
    # The energy is 7/10 m v^2; 5/7 of it is translation.
    assert motion.energy[0] == pytest.approx(0.7 * 0.170097, rel=1e-14)
    assert motion.energy_translation[0] == pytest.approx(0.5 * 0.170097, rel=1e-14)
    # The contact is a sample, so a ball that passes through another one would be detected.
    assert largest_overlap(result) < 1e-15


def test_a_stored_motion_tells_sliding_from_rolling_and_bends_where_the_path_does() -> None:
    # The spin lasts a minute: on the uniform grid, the slide would be a few long chords.
    masse = Scene(
        name="masse",
        physics=Physics(motion="sliding"),
        balls=[
            Ball(
                id="cue",
                position=(0.0, 0.0),
                velocity=(2.0, 0.0),
                angular_velocity=(-90.0, -40.0, 600.0),
            )
        ],
    )
    result = simulate(masse, record="trajectory")
    motion = motion_of(result)
    assert motion.phases is not None
    assert motion.phases.tolist() == result.phases(motion.times).tolist()
    slides = motion.times[motion.phases[:, 0] == Phase.SLIDING]
    assert slides[0] == 0.0
    middles = result.sample((motion.times[1:] + motion.times[:-1]) / 2).positions[:, 0]
    chords = (motion.positions[1:, 0] + motion.positions[:-1, 0]) / 2
    assert (
        np.max(np.linalg.norm((middles - chords)[:, :2], axis=1)[: len(slides)]) <= PATH_DEVIATION
    )


def test_frames_are_stored_without_phases() -> None:
    result = make_engine("paper-discrete").simulate(SHOT, record="trajectory")
    assert motion_of(result).phases is None


@pytest.mark.parametrize("spec", ["ghostball", "pymunk", "pymunk:contact_steps=exact"])
def test_a_ball_that_is_gone_overlaps_none(spec: str) -> None:
    """Both balls fall into the same pocket, and their last positions overlap by 57 mm."""
    shot = Scene.model_validate(
        {
            "name": "shot",
            "table": "wpa-9ft",
            "balls": [
                {"id": "first", "position": (1.27, 0.4), "velocity": (0.0, -1.0)},
                {"id": "second", "position": (1.27, 0.6), "velocity": (0.0, -1.0)},
            ],
        }
    )
    result = make_engine(spec).simulate(shot, record="trajectory")
    gone = times_gone(result)
    assert result.events is not None
    assert gone.tolist() == result.events["t"].tolist()
    places = result.rest_positions
    assert places[0] == pytest.approx(places[1], abs=1e-9)
    assert largest_overlap(result) == 0.0


# Impacts that last: overlapping balls have contact energy, which limits the overlap


def in_contact(impacts: str, overlap: float):
    """Return a run in three frames: before an impact, in the middle of it, and after it."""
    physics = Physics(rolling_friction=0.0, impacts=impacts)
    scene = SHOT.model_copy(update={"physics": physics, "t_max": 0.3})
    reach = 2.0 * scene.balls[0].radius
    xs = np.array([[0.0, 0.5], [0.5 - reach, 0.5 - overlap], [0.5 - reach, 0.6]])
    speeds = np.array([[1.0, 0.0], [0.5, 0.4], [0.0, 1.0]])
    places, velocities = np.zeros((2, 3, 2, 3))
    places[:, :, 0], velocities[:, :, 0] = xs, speeds
    places[:, :, 2] = 0.5 * reach
    frames = SampledTrajectory(np.array([0.0, 0.1, 0.3]), places, velocities, 0.0 * places)
    return replace(simulate(scene, record="events"), trajectory=frames)


def test_frames_in_which_balls_push_each_other_have_no_energy_of_their_own() -> None:
    for impacts, count in (("simultaneous", 3), ("compliant", 2)):
        run = in_contact(impacts, 1e-4)
        assert len(energy_series(run)) == len(momentum_series(run)) == count
    lost = in_contact("compliant", 1e-4)
    lost.trajectory.velocities[2, 1, 0] = 1.5  # an energy gain is still detected
    energy = energy_series(lost)
    assert energy[1] > 2.0 * energy[0]


def test_balls_that_touch_at_rest_are_not_in_an_impact() -> None:
    run = in_contact("compliant", 1e-4)
    run.trajectory.velocities[1] = 0.0
    assert len(energy_series(run)) == 3


def test_the_deepest_contact_is_that_of_a_ball_that_stops_at_another() -> None:
    # The reduced mass is the mass of the ball, as if it hit a wall of its material and radius.
    scene = in_contact("compliant", 0.0).scene
    ball = scene.balls[0]
    modulus = 5.84e9 / (2.0 * (1.0 - 0.34**2))
    stiff = stiffness(modulus, ball.radius, ball.radius)
    rolls = 1.4 * ball.mass  # a rolling ball also turns
    assert deepest_contact(scene) == pytest.approx(deepest_overlap(1.0, stiff, rolls), rel=1e-12)
    assert deepest_contact(SHOT) == 0.0
