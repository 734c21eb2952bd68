from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks import breaks, racks
from benchmarks.__main__ import app
from benchmarks.breaks import BreaksMeasurement, starts_of
from benchmarks.racks import (
    RacksMeasurement,
    TimedEngine,
    measure_racks,
    timed_ghostball,
    timed_peer,
)
from benchmarks.scenes import POOL_TABLE, random_rack
from ghostball.engine import simulate
from ghostball.model import (
    Ball,
    EngineFailedError,
    GhostballError,
    Scene,
    Status,
    UnsupportedSceneError,
)
from ghostball.reference_adapters import EngineUnavailableError, make_engine
from ghostball.validation.scenes.gases import FRICTIONLESS, packed_gas

# Each rack has its own time; an engine that fails is reported and not run again


class Counting(TimedEngine):
    """An engine that takes longer in each run, and fails after a number of runs."""

    def __init__(self, name, fails_at=None, error=None):
        super().__init__(name, "1.0", self.answer)
        self.asked, self.fails_at, self.failure = [], fails_at, error

    def answer(self, scene):
        self.asked.append(scene)
        if len(self.asked) == self.fails_at:
            raise self.failure
        return float(len(self.asked))


@pytest.fixture
def ours(monkeypatch):
    """A stand-in for Ghostball's engine."""
    monkeypatch.setattr(racks, "WARM_UP_RACKS", 1)
    monkeypatch.setattr(racks, "PEER_RACKS", 2)
    return Counting("ghostball")


def test_each_rack_has_the_median_of_its_rounds_and_peers_play_the_first_once(ours):
    other = Counting("peer")
    measured = measure_racks(ours, [other], rounds=3, racks=4)
    assert [scene.name for scene in ours.asked[:3]] == ["rack-0", "rack-0", "rack-1"]
    assert other.asked == [random_rack(number) for number in (0, 0, 1)]
    mine, theirs = measured.engines
    assert mine.seconds == (6.0, 7.0, 8.0, 9.0)  # the second of three rounds
    assert theirs.seconds == (2.0, 3.0)
    assert (mine.figures.median, mine.figures.mean) == (7.5, 7.5)
    assert (mine.figures.p99, mine.figures.greatest) == (9.0, 9.0)


@pytest.mark.parametrize(
    ("fails_at", "error"),
    [
        (1, EngineUnavailableError("get it")),
        (1, UnsupportedSceneError("peer", ("no cloth",))),
        (3, EngineFailedError("peer", "gone")),
    ],
)
def test_a_peer_that_fails_is_asked_no_more_and_says_why(ours, fails_at, error):
    other = Counting("peer", fails_at, error)
    theirs = measure_racks(ours, [other], rounds=2, racks=4).engines[1]
    assert (theirs.detail, theirs.seconds) == (str(error), ())
    assert theirs.figures.count == 0
    assert len(other.asked) == fails_at


def test_our_engine_plays_and_its_numbers_are_read_back(tmp_path):
    measured = measure_racks(timed_ghostball(), rounds=1, racks=2)
    (mine,) = measured.engines
    assert (mine.engine, len(mine.seconds)) == ("ghostball", 2)
    assert min(mine.seconds) > 0.0
    assert RacksMeasurement.load(measured.save(tmp_path)) == measured


SCENE = packed_gas(2, 0.1, FRICTIONLESS, 0.5)


@pytest.fixture
def played_by(monkeypatch):
    """Return a function that makes a peer with a given adapter."""

    def make(simulate):
        engine = make_engine("paper-discrete")
        monkeypatch.setattr(type(engine), "simulate", lambda _, scene, **__: simulate(scene))
        return timed_peer("paper-discrete")

    return make


def test_impacts_come_one_by_one_where_an_engine_knows_no_other(played_by):
    asked = []
    result = make_engine("paper-discrete").simulate(SCENE)

    def simulate(scene):
        asked.append(scene.physics.impacts)
        if scene.physics.impacts == "simultaneous":
            raise UnsupportedSceneError("peer", ("one after another",))
        return replace(result, scene=scene)

    physics = SCENE.physics.model_copy(update={"impacts": "simultaneous"})
    played = played_by(simulate).play(SCENE.model_copy(update={"physics": physics}))
    assert played == result.wall_time
    assert asked == ["simultaneous", "sequential"]


def test_a_run_that_broke_off_is_no_measurement(played_by):
    result = make_engine("paper-discrete").simulate(SCENE)
    result = replace(result, status=Status.STEP_LIMIT)
    with pytest.raises(EngineFailedError):
        played_by(lambda _: result).play(SCENE)


def test_an_adapter_whose_package_is_missing_is_absent(monkeypatch, ours):
    engine = type(make_engine("pymunk"))
    monkeypatch.setattr(engine, "unavailable", classmethod(lambda _: "pip install pymunk"))
    absent = measure_racks(ours, [timed_peer("pymunk")], rounds=1, racks=2).engines[1]
    assert "pip install pymunk" in absent.detail


@pytest.mark.parametrize(("name", "message"), [("pymnk", "pymunk"), ("pymunk:step=1", "step")])
def test_an_unknown_peer_or_setting_is_refused(name, message):
    with pytest.raises(GhostballError, match=message):
        timed_peer(name)


# Breaks as arrays are equal to breaks as scenes, and the counts include all breaks


def scene_of(positions, velocities):
    """Return the scene of one break, as by `random_rack`."""
    balls = [
        Ball(**{**dict(ball), "position": tuple(x), "velocity": (*v, 0.0)})
        for ball, x, v in zip(
            random_rack(0).balls, positions.tolist(), velocities.tolist(), strict=True
        )
    ]
    return Scene(name="one", table=POOL_TABLE, physics=random_rack(0).physics, balls=balls)


def test_racks_as_arrays_equal_racks_as_scenes():
    positions, velocities = starts_of(part=3, count=4)
    frozen = random_rack(1)
    assert np.array_equal(positions[1, 1:], frozen.positions[1:, :2])
    assert np.all(np.diff(positions[0, [1, 2], 0]) > np.diff(positions[1, [1, 2], 0]))
    speeds = np.hypot(*velocities[:, 0].T)
    assert np.all((speeds >= 4.0) & (speeds <= 12.0))
    assert not np.any(velocities[:, 1:])


def test_counts_include_all_breaks_and_equal_those_of_scenes(monkeypatch):
    monkeypatch.setattr(breaks, "BATCH_SIZE", 3)
    measured = breaks.breaks(5)
    one_by_one = [
        simulate(scene_of(*start))
        for part, count in ((0, 3), (1, 2))
        for start in zip(*starts_of(part, count), strict=True)
    ]
    assert measured.events == sum(result.work["events"] for result in one_by_one)
    assert measured.most_events == max(result.work["events"] for result in one_by_one)
    assert (measured.breaks, measured.not_at_rest) == (5, 0)


def test_the_command_shows_and_writes_them_and_stores_whole_ones_only(tmp_path):
    arguments = ["breaks", "--count", "4", "--out", str(tmp_path)]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert BreaksMeasurement.load(tmp_path / "breaks.json").breaks == 4
    refused = CliRunner().invoke(app, [*arguments, "--store"])
    assert refused.exit_code == 2
    assert "--count" in refused.output
