"""Worlds use the same client one after the other, without affecting each other."""

from __future__ import annotations

import hashlib
from functools import partial

import pytest

from ghostball.model import Result
from ghostball.reference_adapters.pybullet import loading, world as pybullet_world
from ghostball.reference_adapters.pybullet.engine import PybulletSettings
from ghostball.reference_adapters.pybullet.world import PybulletWorld
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.scenes.library import find_scene

pytestmark = pytest.mark.skipif(
    loading.unavailable() is not None, reason=str(loading.unavailable())
)

ROLLING = ("half-ball-cut", "unequal-balls", "rail-into", "cradle", "break-7")
SLIDING = ("draw-shot", "throw-slip", "english-check")

SHOTS = {
    "pybullet": ROLLING + SLIDING,
    "pybullet:contact_steps=exact": ROLLING,
    "pybullet:config=naive": ROLLING + SLIDING,
}


@pytest.fixture(autouse=True)
def _no_idle_clients(monkeypatch):
    monkeypatch.setattr(pybullet_world, "_IDLE_CLIENTS", {"tuned": [], "naive": []})


def bits(result: Result) -> str:
    assert result.events is not None
    end = result.final_state
    parts = (end.positions, end.velocities, end.angular_velocities, result.events)
    return hashlib.sha256(b"".join(part.tobytes() for part in parts)).hexdigest()


def play(name: str, label: str) -> str:
    scene = find_scene(name).model_copy(update={"t_max": 0.6})
    return bits(make_engine(label).simulate(scene, record="events"))


@pytest.mark.parametrize("label", SHOTS)
def test_a_client_that_others_used_gives_the_same_bits(label, monkeypatch):
    fresh = {}
    for name in SHOTS[label]:
        with monkeypatch.context() as alone:
            alone.setattr(pybullet_world, "_IDLE_CLIENTS", {"tuned": [], "naive": []})
            fresh[name] = play(name, label)
    for name in (*SHOTS[label], *reversed(SHOTS[label])):
        assert play(name, label) == fresh[name], name
    assert sum(map(len, pybullet_world._IDLE_CLIENTS.values())) == 1


def test_worlds_at_once_have_a_client_each():
    scene = find_scene("head-on")
    make = partial(PybulletWorld, scene, PybulletSettings(), own_cloth=False)
    with make() as one, make() as other:
        assert one._client != other._client


def test_closes_its_client_also_when_a_run_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    play("head-on", "pybullet")
    bullet = loading.load()

    def connected() -> list[bool]:
        return [bullet.getConnectionInfo(client)["isConnected"] for client in range(8)]

    before = connected()
    monkeypatch.setattr(pybullet_world, "_IDLE_CLIENTS", {"tuned": [], "naive": []})

    def fail(world: pybullet_world.PybulletWorld, dt: float) -> None:
        raise RuntimeError("no step")

    monkeypatch.setattr(pybullet_world.PybulletWorld, "advance", fail)
    with pytest.raises(RuntimeError, match="no step"):
        play("head-on", "pybullet")
    monkeypatch.setattr(pybullet_world.PybulletWorld, "_build", fail)
    with pytest.raises(RuntimeError, match="no step"):
        play("head-on", "pybullet")
    assert connected() == before
