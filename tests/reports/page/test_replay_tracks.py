"""The path of a ball in parabolic pieces, without a visible error."""

import numpy as np
import pytest
from replay_decoder import Packed, decoded, place_at, turned_by

from ghostball.engine import simulate
from ghostball.model import Phase
from ghostball.reports.page.replay_data import scene_data
from ghostball.reports.page.replay_tracks import TOLERANCE, packed, tick_of, track_of
from ghostball.reports.shots import Run, Shot
from ghostball.validation.runs.sampling import motion_of
from ghostball.validation.scenes.library import find_scene


def motion_data(scene, motion):
    return scene_data(Shot(scene, (Run("ghostball", None, motion),)))


@pytest.mark.parametrize("name", ["half-ball-cut", "draw-shot", "masse", "break-8", "flight-jump"])
def test_paths_stay_within_the_tolerance_of_every_stored_sample(name):
    # Fails for pieces that are too long, a wrong sign of the bulge, or coarsely rounded times.
    scene = find_scene(name)
    motion = motion_of(simulate(scene, record="trajectory"))
    data = motion_data(scene, motion)
    _, tracks = decoded(data)["ghostball"]
    for ball, track in enumerate(tracks):
        off = [
            np.linalg.norm(place_at(track, t, data["quantum"]) - place)
            for t, place in zip(motion.times, motion.positions[:, ball], strict=True)
        ]
        assert max(off) <= TOLERANCE + 2e-6  # the end of a piece has also an error of a tick


@pytest.mark.parametrize("name", ["around-the-table", "masse", "flight-bounces"])
def test_balls_turn_as_they_did(name):
    # Fails for spins of the wrong end, for a bounce inside a piece, or for a decay that is cut off.
    scene = find_scene(name)
    result = simulate(scene, record="trajectory")
    data = motion_data(scene, motion_of(result))
    _, tracks = decoded(data)["ghostball"]
    wanted = result.orientation([result.rest_time])[0]
    for track, radius, right in zip(tracks, scene.radii, wanted, strict=True):
        cosine = abs(turned_by(data, track, radius) @ right)
        assert 2.0 * np.arccos(min(cosine, 1.0)) < 0.1


def test_a_ball_that_rolls_is_one_parabola_until_it_is_hit():
    scene = find_scene("half-ball-cut")
    motion = motion_of(simulate(scene, record="trajectory"))
    for ball in (0, 1):
        own = (motion.events["a"] == ball) | (motion.events["b"] == ball)
        track = track_of(motion, ball, tick_of(motion), scene.radii[ball])
        assert len(track.bulges) <= own.sum() + 1


def test_phases_are_those_of_the_motion():
    # Fails if a piece contains a change of phase.
    scene = find_scene("draw-shot")
    motion = motion_of(simulate(scene, record="trajectory"))
    _, tracks = decoded(motion_data(scene, motion))["ghostball"]
    for ball, track in enumerate(tracks):
        piece = np.searchsorted(track["t"], motion.times + 1e-7, side="right") - 1
        said = np.array(track["phases"])[np.clip(piece, 0, len(track["phases"]) - 1)]
        # A time just before an event is within a tick of the event; at the end there is no piece.
        clear = np.append(np.diff(motion.times) > 2e-7, False)
        assert (said[clear] == motion.phases[clear, ball]).all()
    assert {Phase.SLIDING, Phase.ROLLING, Phase.RESTING} <= {
        phase for track in tracks for phase in track["phases"]
    }


def test_numbers_of_every_size_are_packed():
    numbers = [0, -1, 1, 63, 64, -64, -65, 2**31, -(2**40), 2**52]
    reader = Packed.__new__(Packed)
    reader.bytes, reader.at = packed(numbers), 0
    assert reader.numbers(len(numbers)) == numbers
    assert len(packed([63])) == 1
