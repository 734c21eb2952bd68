"""Fails where a peer that is absent, can't or crashes is taken for anything else, or goes on."""

import dataclasses

import pytest
from engine_facts import needs

from benchmarks.peer_engines import (
    DEFAULT_PEERS,
    AdapterPeer,
    PeerAbsentError,
    PeerCannotError,
    PeerFailedError,
    make_peers,
)
from benchmarks.scenes import racked_break, table_gas
from ghostball.engine import EngineFailedError, GhostballError, Status, UnsupportedSceneError
from ghostball.reference_adapters.registry import EngineUnavailableError
from ghostball.reference_adapters.workers.process import installed
from ghostball.validation.scenes.gases import FULL_CLOTH

SCENE = table_gas(2, 0.5)


def played_by(monkeypatch, simulate):
    """Return a peer whose adapter does what `simulate` says."""
    peer = AdapterPeer("paper-discrete")
    monkeypatch.setattr(
        type(peer._engine), "simulate", lambda self, scene, **_: simulate(self, scene)
    )
    return peer


def saying(error):
    def simulate(engine, scene):
        raise error

    return simulate


@pytest.mark.parametrize(
    ("raised", "told"),
    [
        (EngineUnavailableError("get it"), PeerAbsentError),
        (UnsupportedSceneError("peer", ("no cloth",)), PeerCannotError),
        (EngineFailedError("peer", "out of chalk"), PeerFailedError),
        (ValueError("bad scene"), PeerFailedError),
    ],
)
def test_what_a_peer_says_is_told_as_what_it_is(monkeypatch, raised, told):
    with pytest.raises(told, match="|".join(("get it", "no cloth", "out of chalk", "bad scene"))):
        played_by(monkeypatch, saying(raised)).simulate(SCENE)


def test_an_engine_that_counts_events_has_those_and_another_its_collisions(monkeypatch):
    result = AdapterPeer("paper-discrete")._engine.simulate(SCENE)
    collisions = sum(result.collision_counts.values())
    assert played_by(monkeypatch, lambda *_: result).simulate(SCENE).events == collisions
    counting = dataclasses.replace(result, work={"events": 41})
    assert played_by(monkeypatch, lambda *_: counting).simulate(SCENE).events == 41


def test_impacts_come_in_the_order_of_an_engine_that_has_none_at_once(monkeypatch):
    asked = []

    def simulate(engine, scene):
        asked.append(scene.physics.impacts)
        if scene.physics.impacts == "simultaneous":
            raise UnsupportedSceneError("peer", ("one after another",))
        return base(engine, scene)

    base = type(AdapterPeer("paper-discrete")._engine).simulate
    physics = SCENE.physics.model_copy(update={"impacts": "simultaneous"})
    scene = SCENE.model_copy(update={"physics": physics})
    played_by(monkeypatch, simulate).simulate(scene)
    assert asked == ["simultaneous", "sequential"]


@needs("pooltool")
def test_the_version_of_a_worker_is_known_before_it_starts():
    assert AdapterPeer("pooltool").version == installed()["pooltool-billiards"]


def test_our_adapters_are_peers(monkeypatch):
    peer = AdapterPeer("paper-discrete")
    assert peer.simulate(SCENE).seconds > 0.0
    with pytest.raises(PeerCannotError, match="paper-discrete"):
        peer.simulate(racked_break(0, FULL_CLOTH))


@pytest.mark.parametrize(
    ("status", "error"),
    [(Status.INTERRUPTED, KeyboardInterrupt), (Status.STEP_LIMIT, PeerFailedError)],
)
def test_a_run_that_broke_off_is_no_measurement(monkeypatch, status, error):
    peer = AdapterPeer("paper-discrete")
    result = dataclasses.replace(peer._engine.simulate(SCENE), status=status)
    monkeypatch.setattr(type(peer._engine), "simulate", lambda *_, **__: result)
    with pytest.raises(error):
        peer.simulate(SCENE)


def test_all_peers_are_there_unless_others_are_asked_for(monkeypatch):
    assert [peer.name for peer in make_peers(None)] == list(DEFAULT_PEERS)
    assert make_peers(["none"]) == []
    names = ["FastFiz", "pymunk:dt=1e-3,mode=native", "pooltool"]
    peers = make_peers(names)
    assert [peer.name for peer in peers] == names
    with pytest.raises(PeerAbsentError, match="C\\+\\+ from source"):
        peers[0].simulate(SCENE)


def test_an_adapter_whose_package_is_missing_is_absent(monkeypatch):
    from ghostball.reference_adapters.pymunk.engine import PymunkEngine

    monkeypatch.setattr(PymunkEngine, "unavailable", classmethod(lambda _: "pip install pymunk"))
    (peer,) = make_peers(["pymunk"])
    with pytest.raises(PeerAbsentError, match="pip install pymunk"):
        peer.simulate(SCENE)


@pytest.mark.parametrize(
    ("names", "message"),
    [
        ("pooltol", 'unknown peer "pooltol" in `--peer`. Did you mean pooltool'),
        ("ghostball", "unknown peer"),
        ("pymunk:step=1", "step"),
        ("", "unknown peer"),
    ],
)
def test_an_unknown_peer_or_setting_is_refused(names, message):
    with pytest.raises(GhostballError) as caught:
        make_peers([names])
    assert message in str(caught.value)
