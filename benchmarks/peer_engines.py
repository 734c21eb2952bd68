"""Other engines, to be measured beside ours: those that have an adapter, and one that has none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Protocol

from benchmarks.running import BenchError
from ghostball.engine import EngineFailedError, Scene, UnsupportedSceneError
from ghostball.reference_adapters import make_engine
from ghostball.reference_adapters.output import captured
from ghostball.reference_adapters.registry import EngineUnavailableError, engine_names
from ghostball.validation.results.environment import versions
from ghostball.validation.runs.playing import ONE_BY_ONE, run_as_it_can


class PeerAbsentError(BenchError):
    """A peer that isn't installed; the message says how to get it."""


class PeerCannotError(BenchError):
    """A scene that the peer can't represent; the message says why."""


class PeerFailedError(BenchError):
    """A run of a peer that broke off."""


@dataclass(frozen=True)
class PeerRun:
    """What a peer gives: wall time of the simulation alone [s], and how many events it had."""

    seconds: float
    events: int


class Peer(Protocol):
    """An engine that is measured beside ours."""

    @property
    def name(self) -> str:
        """What it is called in tables."""

    @property
    def version(self) -> str:
        """Version of its package; "" where it has none."""

    def simulate(self, scene: Scene) -> PeerRun:
        """Run a scene to its end.

        Raises
        ------
        PeerAbsentError, PeerCannotError, PeerFailedError
        """


class AdapterPeer:
    """An engine with an adapter; its events are those that it counts, or else its collisions.

    Impacts that share a ball come in the engine's own order, where it can't take them at once.
    """

    def __init__(self, spec: str) -> None:
        self._engine = make_engine(spec)
        self.name = spec
        package = _PACKAGES.get(self._engine.name, self._engine.name)
        self.version = versions().get(package) or ""

    def simulate(self, scene: Scene) -> PeerRun:
        """Run a scene to its end."""
        try:
            with captured():
                result = run_as_it_can(self._engine, scene, ({}, ONE_BY_ONE), "rest")
        except EngineUnavailableError as error:
            raise PeerAbsentError(str(error)) from None
        except UnsupportedSceneError as error:
            raise PeerCannotError(str(error)) from None
        except EngineFailedError as error:
            raise PeerFailedError(str(error)) from None
        if not result.status.complete:
            raise PeerFailedError(f"{result.status.value}: {result.reason}")
        collisions = sum(result.collision_counts.values())
        return PeerRun(result.wall_time, int(result.work.get("events", collisions)))


class AbsentPeer:
    """An engine that can't be had here; listed all the same, with how to get it."""

    version = ""

    def __init__(self, name: str, get: str) -> None:
        self.name = name
        self._get = get

    def simulate(self, scene: Scene) -> PeerRun:
        """Say that it is absent."""
        del scene
        raise PeerAbsentError(self._get)


_PACKAGES = {"pooltool": "pooltool-billiards"}
"""What an engine is installed as, where that is another name."""

_ABSENT = {
    "FastFiz": "C++ from source, with GSL; no package, and no way to drive it from here yet",
}
DEFAULT_PEERS = ("pooltool", "FastFiz", "billiards", "pymunk:dt=1e-3", "pybullet:dt=1e-3")
"""Those that are measured unless others are asked for."""


def make_peers(names: Sequence[str] | None) -> list[Peer]:
    """Return the peers that a list names.

    Parameters
    ----------
    names : sequence of str or None
        Such as pooltool, billiards, FastFiz, or an engine as for `--engine`; "none" alone is none,
        None is `DEFAULT_PEERS`.

    Raises
    ------
    GhostballError
        Where one is unknown, or has a setting that its engine doesn't know.
    """
    if names is not None and [*names] == ["none"]:
        return []
    return [_make_peer(name) for name in (DEFAULT_PEERS if names is None else names)]


def _make_peer(name: str) -> Peer:
    if name in _ABSENT:
        return AbsentPeer(name, _ABSENT[name])
    known = [*_ABSENT, *(n for n in engine_names() if n != "ghostball")]
    family = name.partition(":")[0]
    if family not in known:
        close = get_close_matches(family, known, n=2)
        hint = f"Did you mean {' or '.join(close)}?" if close else f"Known: {', '.join(known)}"
        raise BenchError(f'unknown peer "{name}" in `--peer`. {hint}')
    try:
        return AdapterPeer(name)
    except EngineUnavailableError as error:
        return AbsentPeer(name, str(error))
