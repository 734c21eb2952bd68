"""Engines that run in a worker process: pooltool and python-billiards.

`make peers` creates a Python environment with both engines; `GHOSTBALL_PEERS_PYTHON` selects a
different environment. Each Ghostball process has one worker, which exits with it.
"""

from __future__ import annotations

import atexit
import os
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from ghostball.model import Record, Result, Scene, UnsupportedSceneError
from ghostball.model.cache_folder import cache_folder
from ghostball.model.features import Capabilities
from ghostball.reference_adapters.answer import EngineAnswer
from ghostball.reference_adapters.base import EngineBase, EngineSettings
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.registry import EngineUnavailableError
from ghostball.reference_adapters.workers.process import (
    PYTHON,
    SCRIPTS,
    Worker,
    WorkerAbsentError,
    interpreter,
)

TIME_LIMIT = 600.0
"""Time limit for the answer of a worker [s]; callers have shorter limits."""


@cache
def worker_of(*command: str, home: Path | None = None) -> Worker:
    """Return the worker that a command starts, the same for each call; it exits with Ghostball.

    `home`: folder that replaces the user's home.
    """
    environment = None
    if home is not None:
        home.mkdir(parents=True, exist_ok=True)
        environment = os.environ | {"HOME": str(home), "XDG_CONFIG_HOME": str(home / "config")}
    worker = Worker([*command], environment)
    atexit.register(worker.close)
    return worker


def run_of(
    engine: str,
    worker: Worker,
    scene: Scene,
    record: Record,
    settings: Mapping[str, Any] | None = None,
) -> EngineAnswer:
    """Simulate a scene in a worker, and return its answer.

    `settings`: additional settings for the worker, if it takes any.

    Raises `EngineUnavailableError` if the worker can't start, `UnsupportedSceneError` if it doesn't
    support the scene, `WorkerFailedError` if it fails, and `EngineError` if the answer is invalid.
    """
    try:
        answer = worker.play(scene, record, TIME_LIMIT, settings)
    except WorkerAbsentError as error:
        raise EngineUnavailableError(f"engine `{engine}` can't start: {error}") from None
    if "cannot" in answer:
        raise UnsupportedSceneError(engine, (str(answer["cannot"]),))
    values: dict[str, Any] = answer | {"engine": engine, "scene": scene.name}
    return EngineAnswer.parse(values, f"the answer of `{engine}`")


class WorkerEngine(EngineBase):
    """An engine that a script in `scripts/` runs in a separate interpreter."""

    MODULE: ClassVar[str]
    CAPABILITIES: ClassVar[ByConfiguration]

    @property
    def capabilities(self) -> Capabilities:
        """How each feature of a scene is supported."""
        return self.CAPABILITIES["always"]

    @classmethod
    def unavailable(cls) -> str | None:
        """Return how to install the interpreter if it is missing, or None."""
        if interpreter().is_file():
            return None
        return (
            "it runs in a separate Python interpreter, which isn't installed. Run `make peers` in "
            f"a checkout, or name one that has it: {PYTHON}=/path/to/python"
        )

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Simulate the scene in the worker."""
        self.check(scene)
        # pooltool reads and writes its default physics in the user's home, which must not affect a
        # run. numba stores compiled code next to the sources, and finds it there again.
        home = cache_folder("workers") / self.MODULE
        # Without PYTHONPATH and the user's packages, which belong to a different interpreter.
        command = (str(interpreter()), "-E", "-s", str(SCRIPTS / "serve.py"), self.MODULE)
        worker = worker_of(*command, home=home)
        return run_of(self.name, worker, scene, record).result(scene, record=record)


_SEQUENTIAL_ONLY = (
    'no impacts = "simultaneous" with touching balls (it resolves one contact after another)'
)


def _has_touching_balls(scene: Scene) -> bool:
    """Return whether two balls of a scene touch initially."""
    n = len(scene.balls)
    distances = np.linalg.norm(scene.positions[:, np.newaxis] - scene.positions, axis=2)
    gaps = distances - (scene.radii[:, np.newaxis] + scene.radii)
    return bool(np.any(gaps[np.triu_indices(n, 1)] < 1e-9))


class PooltoolEngine(WorkerEngine):
    """pooltool: slide, roll, spin and rest, from event to event."""

    name: ClassVar[str] = "pooltool"
    Settings: ClassVar[type[EngineSettings]] = EngineSettings
    MODULE: ClassVar[str] = "pooltool_peer"
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "pooltool")

    def _lacking(self, scene: Scene) -> Iterator[str]:
        if scene.physics.motion == "rolling":
            yield "no pure rolling (its balls slide before they roll)"
        if scene.physics.impacts == "simultaneous" and _has_touching_balls(scene):
            yield _SEQUENTIAL_ONLY

    def resolution(self, scene: Scene) -> float:  # noqa: ARG002
        """Return the distance by which pooltool moves balls at an impact [m]."""
        return 1e-6


class BilliardsEngine(WorkerEngine):
    """python-billiards: elastic discs without friction, from collision to collision."""

    name: ClassVar[str] = "billiards"
    Settings: ClassVar[type[EngineSettings]] = EngineSettings
    MODULE: ClassVar[str] = "billiards_peer"
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "billiards")

    def _lacking(self, scene: Scene) -> Iterator[str]:
        if np.any(scene.rolling_frictions != 0.0):
            yield "no cloth friction (it has no friction)"
        if scene.t_max is None:
            yield "no shots that run until rest (it has no friction: set `t_max`)"
        if scene.physics.impacts == "simultaneous" and _has_touching_balls(scene):
            yield _SEQUENTIAL_ONLY

    def resolution(self, scene: Scene) -> float:  # noqa: ARG002
        """Return 0: the engine advances from collision to collision and only rounds."""
        return 0.0
