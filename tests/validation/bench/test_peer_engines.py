"""Fails where a peer that is absent, can't or crashes is taken for anything else, or goes on."""

import json
import shutil
import sys
from pathlib import Path

import pytest

from ghostball.engine import GhostballError, Status
from ghostball.validation.bench import peer_engines
from ghostball.validation.bench.peer_engines import (
    DEFAULT_PEERS,
    AdapterPeer,
    PeerAbsentError,
    PeerCannotError,
    PeerFailedError,
    PeerRun,
    ScriptPeer,
    make_peers,
)
from ghostball.validation.bench.running import BenchError
from ghostball.validation.bench.scenes import FULL_CLOTH, racked_break, table_gas

SCENE = table_gas(2, 0.5)
PEER = """
import os, sys
def version():
    return "9.1"
def simulate(scene):
    print("chatter of the peer")
    name = scene["name"]
    if name == "no-cloth":
        return {"cannot": "it has no cloth"}
    if name == "bad":
        raise ValueError("bad scene")
    if name == "crash":
        sys.stderr.write("out of chalk\\n")
        sys.stderr.flush()
        os._exit(3)
    if name == "hang":
        import time
        time.sleep(60)
    return {"seconds": 0.25, "events": len(scene["balls"])}
"""


@pytest.fixture
def script(tmp_path, monkeypatch):
    """Return a maker of peers that this interpreter serves from the test's own module."""
    shutil.copy(peer_engines.SCRIPTS / "serve.py", tmp_path)
    (tmp_path / "mine.py").write_text(PEER)
    (tmp_path / "lacking.py").write_text("import chipmunk_that_is_nowhere")
    monkeypatch.setattr(peer_engines, "SCRIPTS", tmp_path)
    made = []

    def make(module="mine", python=Path(sys.executable)):
        made.append(ScriptPeer("mine", module, python))
        return made[-1]

    yield make
    for peer in made:
        peer.close()


def called(name):
    return SCENE.model_copy(update={"name": name})


def test_a_script_answers_scene_after_scene(script):
    peer = script()
    assert [peer.simulate(SCENE) for _ in range(3)] == [PeerRun(0.25, 2)] * 3
    assert peer.version == "9.1"
    with pytest.raises(PeerCannotError, match="it has no cloth"):
        peer.simulate(called("no-cloth"))
    with pytest.raises(PeerFailedError, match="ValueError: bad scene"):
        peer.simulate(called("bad"))
    assert peer.simulate(SCENE) == PeerRun(0.25, 2)


def test_a_crash_is_told_with_its_last_words_and_the_next_scene_starts_anew(script):
    peer = script()
    with pytest.raises(PeerFailedError, match="ended without an answer: out of chalk"):
        peer.simulate(called("crash"))
    assert peer.simulate(SCENE) == PeerRun(0.25, 2)


def test_a_peer_that_hangs_is_given_up(script, monkeypatch):
    peer = script()
    peer.simulate(SCENE)
    monkeypatch.setattr(peer_engines, "LONGEST", 0.2)
    with pytest.raises(PeerFailedError, match="without an answer: over 0 s"):
        peer.simulate(called("hang"))


@pytest.mark.parametrize(
    ("module", "python"), [("lacking", Path(sys.executable)), ("mine", Path("nowhere/python"))]
)
def test_an_absent_peer_says_how_to_get_it(script, module, python):
    with pytest.raises(PeerAbsentError, match="make peers"):
        script(module, python).simulate(SCENE)


def test_a_peer_is_sent_all_of_a_scene(script, tmp_path):
    (tmp_path / "echo.py").write_text(
        "import json, pathlib\ndef version(): return '1'\ndef simulate(scene):\n"
        f"    pathlib.Path({str(tmp_path / 'sent')!r}).write_text(json.dumps(scene))\n"
        "    return {'seconds': 1, 'events': 1}\n"
    )
    scene = racked_break(0, FULL_CLOTH)
    script("echo").simulate(scene)
    sent = json.loads((tmp_path / "sent").read_text())
    assert type(scene).model_validate(sent) == scene
    assert sent["physics"]["cushion"] == "han2005"  # presets are resolved


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
    import dataclasses

    peer = AdapterPeer("paper-discrete")
    result = dataclasses.replace(peer._engine.simulate(SCENE), status=status)
    monkeypatch.setattr(type(peer._engine), "simulate", lambda *_, **__: result)
    with pytest.raises(error):
        peer.simulate(SCENE)


def test_all_peers_are_there_unless_others_are_asked_for(monkeypatch):
    assert [peer.name for peer in make_peers(None, None)] == list(DEFAULT_PEERS)
    assert make_peers("none", None) == []
    names = ["FastFiz", "pymunk:dt=1e-3,mode=native", "pooltool"]
    peers = make_peers(",".join(names), None)
    assert [peer.name for peer in peers] == names
    with pytest.raises(PeerAbsentError, match="C\\+\\+ from source"):
        peers[0].simulate(SCENE)
    for peer in peers:
        peer.close()


def test_an_adapter_whose_package_is_missing_is_absent(monkeypatch):
    from ghostball.reference_adapters.pymunk.engine import PymunkEngine

    monkeypatch.setattr(PymunkEngine, "unavailable", classmethod(lambda _: "pip install pymunk"))
    (peer,) = make_peers("pymunk", None)
    with pytest.raises(PeerAbsentError, match="pip install pymunk"):
        peer.simulate(SCENE)


@pytest.mark.parametrize(
    ("names", "message"),
    [
        ("pooltol", 'unknown peer "pooltol" in `--peers`. Did you mean pooltool'),
        ("ghostball", "unknown peer"),
        ("pymunk:step=1", "step"),
        ("pymunk,,pybullet", "between commas"),
    ],
)
def test_an_unknown_peer_or_setting_is_refused(names, message):
    with pytest.raises(GhostballError) as caught:
        make_peers(names, None)
    assert message in str(caught.value)


def test_an_interpreter_that_is_no_file_is_refused(tmp_path):
    with pytest.raises(BenchError, match="`--peer-python` must be a Python interpreter"):
        make_peers(None, tmp_path / "nowhere")
