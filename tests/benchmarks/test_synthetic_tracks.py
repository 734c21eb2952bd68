"""Synthetic tracks with known physics have the errors of a camera and are reproducible."""

from __future__ import annotations

import numpy as np

from benchmarks.synthetic_tracks import POOL, synthetic_tracks, write_tracks
from ghostball.model import Physics
from ghostball.validation.measured.fit.curves import noise_of
from ghostball.validation.measured.tracks import read_tracks

PHYSICS = Physics(preset="pool")


def test_samples_are_as_often_as_noisy_and_as_stale_as_asked():
    shots = synthetic_tracks(PHYSICS, 12, 1, rate=25.0, noise=2e-3, stale=0.05)
    tracks = [track for balls in shots.values() for track in balls.values()]
    assert len(tracks) == 36
    assert all(np.allclose(np.diff(track.times), 0.04) for track in tracks)
    assert np.isclose(noise_of(tracks), 2e-3, rtol=0.15)
    stale = [np.all(track.positions[1:] == track.positions[:-1], axis=1) for track in tracks]
    assert 0.04 < np.mean(np.concatenate(stale)) < 0.06


def test_one_seed_is_one_table():
    one, again = (synthetic_tracks(PHYSICS, 2, 5)["2"]["cue"] for _ in range(2))
    assert np.array_equal(one.positions, again.positions)
    assert not np.array_equal(one.positions, synthetic_tracks(PHYSICS, 2, 6)["2"]["cue"].positions)


def test_balls_at_rest_are_left_out_but_for_their_beginning():
    shots = synthetic_tracks(PHYSICS, 5, 2, resting=False)
    lengths = [len(track.times) for balls in shots.values() for track in balls.values()]
    assert 1 in lengths
    assert all(track.times[0] == 0.0 for balls in shots.values() for track in balls.values())


def test_written_tracks_are_read_back(tmp_path):
    shots = synthetic_tracks(PHYSICS, 3, 4)
    write_tracks(tmp_path / "tracks.csv", shots, "made up")
    again = read_tracks(tmp_path / "tracks.csv", POOL)
    for shot, balls in shots.items():
        for ball, track in balls.items():
            assert np.allclose(again[shot][ball].positions, track.positions, atol=6e-5)
