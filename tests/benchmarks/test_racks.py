"""Fails where a rack's time is lost or another's, or a peer that can't is asked on or not told."""

import pytest
from peers import FakePeer

from benchmarks import measurements, racks
from benchmarks.peer_engines import PeerCannotError, PeerFailedError, PeerRun
from benchmarks.racks import RacksMeasurement, measure_racks
from benchmarks.scenes import random_rack


class Counting(FakePeer):
    """Takes longer each time that it is asked, and fails when it was asked too often."""

    def __init__(self, name, fails_at=None, error=None):
        super().__init__(name)
        self.fails_at, self.failure = fails_at, error

    def simulate(self, scene):
        super().simulate(scene)
        if len(self.asked) == self.fails_at:
            raise self.failure
        return PeerRun(float(len(self.asked)), 1)


@pytest.fixture
def ours(monkeypatch):
    """Another engine in the place of ours."""
    engine = Counting("ghostball")
    monkeypatch.setattr(racks, "OurEngine", lambda: engine)
    monkeypatch.setattr(racks, "WARMING", 1)
    monkeypatch.setattr(racks, "PEER_RACKS", 2)
    return engine


def test_each_rack_has_the_median_of_its_rounds_and_peers_play_the_first_once(ours):
    peer = Counting("peer")
    measured = measure_racks([peer], rounds=3, racks=4)
    assert [scene.name for scene in ours.asked[:3]] == ["rack-0", "rack-0", "rack-1"]
    assert peer.asked == [random_rack(number) for number in (0, 0, 1)]
    mine, theirs = measured.engines
    assert mine.seconds == (6.0, 7.0, 8.0, 9.0)  # the second of three rounds
    assert theirs.seconds == (2.0, 3.0)
    assert (mine.figures.median, mine.figures.mean) == (7.5, 7.5)
    assert (mine.figures.p99, mine.figures.slowest) == (9.0, 9.0)
    assert measured.quick


@pytest.mark.parametrize(
    ("fails_at", "error", "outcome"),
    [(1, PeerCannotError("no cloth"), "not-representable"), (3, PeerFailedError("gone"), "failed")],
)
@pytest.mark.usefixtures("ours")
def test_a_peer_that_fails_is_asked_no_more_and_says_why(fails_at, error, outcome):
    peer = Counting("peer", fails_at, error)
    theirs = measure_racks([peer], rounds=2, racks=4).engines[1]
    assert (theirs.outcome, theirs.detail, theirs.seconds) == (outcome, str(error), ())
    assert theirs.figures is None
    assert len(peer.asked) == fails_at


@pytest.mark.usefixtures("ours")
def test_an_interrupt_keeps_what_is_there():
    peer = Counting("peer", 2, KeyboardInterrupt())
    measured = measure_racks([peer], rounds=1, racks=4)
    assert measured.interrupted
    assert measured.anything
    assert [len(one.seconds) for one in measured.engines] == [4, 0]


def test_our_engine_plays_and_its_numbers_are_read_back(tmp_path):
    measured = measure_racks(rounds=1, racks=2)
    (mine,) = measured.engines
    assert (mine.engine, mine.outcome, len(mine.seconds)) == ("ghostball", "ran", 2)
    assert min(mine.seconds) > 0.0
    path = tmp_path / "racks.json"
    measurements.save(measured, path, "--out")
    assert measurements.load(path, RacksMeasurement) == measured
