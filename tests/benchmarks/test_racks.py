"""Fails where a rack's time is lost or another's, or one that can't is asked on or not reported."""

from dataclasses import replace

import pytest

from benchmarks import racks
from benchmarks.racks import Player, RacksMeasurement, measure_racks, our_player, peer
from benchmarks.scenes import random_rack, table_gas
from ghostball.model import EngineFailedError, GhostballError, Status, UnsupportedSceneError
from ghostball.reference_adapters import EngineUnavailableError, make_engine


class Counting(Player):
    """Takes longer each time that it is asked, and fails when it was asked too often."""

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
    """Another engine in the place of ours."""
    monkeypatch.setattr(racks, "WARMING", 1)
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
    assert (mine.figures.p99, mine.figures.slowest) == (9.0, 9.0)


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
    assert theirs.figures is None
    assert len(other.asked) == fails_at


def test_our_engine_plays_and_its_numbers_are_read_back(tmp_path):
    measured = measure_racks(our_player(), rounds=1, racks=2)
    (mine,) = measured.engines
    assert (mine.engine, len(mine.seconds)) == ("ghostball", 2)
    assert min(mine.seconds) > 0.0
    assert RacksMeasurement.load(measured.save(tmp_path)) == measured


SCENE = table_gas(2, 0.5)


@pytest.fixture
def played_by(monkeypatch):
    """Return what makes a peer whose adapter does what it is asked to."""

    def make(simulate):
        engine = make_engine("paper-discrete")
        monkeypatch.setattr(type(engine), "simulate", lambda _, scene, **__: simulate(scene))
        return peer("paper-discrete")

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
    absent = measure_racks(ours, [peer("pymunk")], rounds=1, racks=2).engines[1]
    assert "pip install pymunk" in absent.detail


@pytest.mark.parametrize(("name", "message"), [("pymnk", "pymunk"), ("pymunk:step=1", "step")])
def test_an_unknown_peer_or_setting_is_refused(name, message):
    with pytest.raises(GhostballError, match=message):
        peer(name)
