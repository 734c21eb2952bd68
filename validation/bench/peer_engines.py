"""Other engines, to be measured beside ours: our adapters here, others in their own interpreter."""

from __future__ import annotations

import json
import subprocess
import tempfile
import threading
from dataclasses import dataclass
from difflib import get_close_matches
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import IO, Any, Protocol

from ghostball.engine import EngineFailedError, Result, Scene, UnsupportedSceneError
from ghostball.reference_adapters import make_engine, split_specs
from ghostball.reference_adapters.output import captured
from ghostball.reference_adapters.registry import EngineUnavailableError, engine_names
from ghostball.validation.bench.running import BenchError
from ghostball.validation.runs.playing import run_engine

SCRIPTS = Path(__file__).resolve().parent / "peers"

PEERS_VENV = Path(__file__).resolve().parent.parent.parent / ".venv-peers"
"""Made by `make peers`, with the peers whose requirements clash with ours."""

LONGEST = 300.0
"""Seconds after which a peer that has not answered is given up."""


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
        """Version of its package; "" before it ran, or where it has none."""

    def simulate(self, scene: Scene) -> PeerRun:
        """Run a scene to its end.

        Raises
        ------
        PeerAbsentError, PeerCannotError, PeerFailedError
        """

    def close(self) -> None:
        """End what it started."""


class AdapterPeer:
    """An engine of `reference_adapters`, in this process; its events are its collisions."""

    def __init__(self, spec: str) -> None:
        self._engine = make_engine(spec)
        self.name = spec
        self.version = _version(self._engine.name)

    def simulate(self, scene: Scene) -> PeerRun:
        """Run a scene to its end."""
        try:
            with captured():
                result = run_engine(self._engine, scene, "rest")
        except UnsupportedSceneError as error:
            raise PeerCannotError(str(error)) from None
        except EngineFailedError as error:
            raise PeerFailedError(str(error)) from None
        _check_complete(result)
        return PeerRun(result.wall_time, sum(result.collision_counts.values()))

    def close(self) -> None:
        """Do nothing: it has no process of its own."""


class ScriptPeer:
    """An engine in an interpreter of its own, which has it installed.

    Parameters
    ----------
    name, module : str
        What it is called, and the module in `peers/` that drives it.
    python : Path or None
        The interpreter; None: that of `make peers`.
    """

    def __init__(self, name: str, module: str, python: Path | None) -> None:
        self.name, self.version = name, ""
        self._module = module
        self._python = python or PEERS_VENV / "bin" / "python"
        self._process: subprocess.Popen[str] | None = None
        self._messages: IO[str] | None = None

    def simulate(self, scene: Scene) -> PeerRun:
        """Run a scene to its end."""
        if self._process is None:
            self._start()
        answer = self._ask(json.dumps(scene.model_dump(mode="json", by_alias=True)))
        if "cannot" in answer:
            raise PeerCannotError(answer["cannot"])
        if "error" in answer:
            raise PeerFailedError(answer["error"])
        return PeerRun(float(answer["seconds"]), int(answer["events"]))

    def close(self) -> None:
        """End its process."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
            for stream in (process.stdin, process.stdout, self._messages):
                if stream is not None:
                    stream.close()

    def _start(self) -> None:
        self._messages = tempfile.TemporaryFile(mode="w+")  # noqa: SIM115 - `close` closes it
        try:
            self._process = subprocess.Popen(
                [str(self._python), str(SCRIPTS / "serve.py"), self._module],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._messages,
                text=True,
            )
        except OSError:
            self._messages.close()
            raise PeerAbsentError(_GET) from None
        hello = self._ask(None)
        if "absent" in hello:
            self.close()
            raise PeerAbsentError(f"{_GET} ({hello['absent']})")
        self.version = str(hello["version"])

    def _ask(self, line: str | None) -> dict[str, Any]:
        """Send a line, or nothing, and read the answer."""
        process = self._process
        assert process is not None
        assert process.stdin is not None
        assert process.stdout is not None
        late = threading.Event()

        def give_up() -> None:
            late.set()
            process.kill()

        watch = threading.Timer(LONGEST, give_up)
        watch.start()
        try:
            if line is not None:
                process.stdin.write(line + "\n")
                process.stdin.flush()
            answer: dict[str, Any] = json.loads(process.stdout.readline())
        except (OSError, ValueError):
            said = f"over {LONGEST:.0f} s" if late.is_set() else self._last_message()
            self.close()
            raise PeerFailedError(f"its process ended without an answer: {said}") from None
        except KeyboardInterrupt:
            self.close()
            raise
        finally:
            watch.cancel()
        return answer

    def _last_message(self) -> str:
        assert self._messages is not None
        self._messages.seek(0)
        return "".join(self._messages.read().strip().splitlines()[-1:])


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

    def close(self) -> None:
        """Do nothing."""


_SCRIPTS = {"pooltool": "pooltool_peer", "billiards": "billiards_peer"}
_GET = "get it with `make peers`, or name an interpreter that has it: --peer-python"
_ABSENT = {
    "FastFiz": "C++ from source, with GSL; no package, and no way to drive it from here yet",
}
DEFAULT_PEERS = ("pooltool", "FastFiz", "billiards", "pymunk:dt=1e-3", "pybullet:dt=1e-3")
"""Those that are measured unless others are asked for."""


def make_peers(names: str | None, python: Path | None) -> list[Peer]:
    """Return the peers that a list names.

    Parameters
    ----------
    names : str or None
        Separated by commas: pooltool, billiards, FastFiz, or an engine as for `--engine`; "none"
        is none, None is `DEFAULT_PEERS`.
    python : Path or None
        The interpreter of those that run in their own.

    Raises
    ------
    GhostballError
        Where one is unknown, has a setting that its engine doesn't know, or `python` is no file.
    """
    if python is not None and not python.is_file():
        raise BenchError(
            f"`--peer-python` must be a Python interpreter, got {str(python)!r}, which is no file"
        )
    if names == "none":
        return []
    chosen = DEFAULT_PEERS if names is None else split_specs(names)
    return [_make_peer(name, python) for name in chosen]


def _make_peer(name: str, python: Path | None) -> Peer:
    if name in _SCRIPTS:
        return ScriptPeer(name, _SCRIPTS[name], python)
    if name in _ABSENT:
        return AbsentPeer(name, _ABSENT[name])
    known = [*_SCRIPTS, *_ABSENT, *(n for n in engine_names() if n != "ghostball")]
    family = name.partition(":")[0]
    if family not in known:
        close = get_close_matches(family, known, n=2)
        hint = f"Did you mean {' or '.join(close)}?" if close else f"Known: {', '.join(known)}"
        raise BenchError(f'unknown peer "{name}" in `--peers`. {hint}')
    try:
        return AdapterPeer(name)
    except EngineUnavailableError as error:
        return AbsentPeer(name, str(error))


def _check_complete(result: Result) -> None:
    if not result.status.complete:
        raise PeerFailedError(f"{result.status.value}: {result.reason}")


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""
