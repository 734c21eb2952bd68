"""Engines whose shots are played by a worker process: pooltool and python-billiards.

`make peers` makes their interpreter, with both; the variable `GHOSTBALL_PEERS_PYTHON` names
another one. A process serves all shots of one of ours, and ends with it.
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
from ghostball.reference_adapters.answer import Run
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

LONGEST = 600.0
"""Time after which a worker that hasn't answered is given up [s]; callers have limits of their own.
"""


@cache
def _worker(module: str, python: Path) -> Worker:
    # pooltool reads its default physics from, and writes them to, the home of its user: no run may
    # depend on that. Numba keeps what it compiled beside the sources, and so finds it again.
    home = cache_folder("workers") / module
    home.mkdir(parents=True, exist_ok=True)
    environment = os.environ | {"HOME": str(home), "XDG_CONFIG_HOME": str(home / "config")}
    # Without PYTHONPATH and the user's packages, which are another interpreter's.
    command = [str(python), "-E", "-s", str(SCRIPTS / "serve.py"), module]
    worker = Worker(command, environment)
    atexit.register(worker.close)
    return worker


def run_of(
    engine: str,
    worker: Worker,
    scene: Scene,
    record: Record,
    longest: float,
    settings: Mapping[str, Any] | None = None,
) -> Run:
    """Have a worker play a scene, and return the run that it answers.

    `settings`: what it is sent besides, where it takes any.

    Raises `EngineUnavailableError` where it can't start, `UnsupportedSceneError` where it says that
    it can't represent the scene, `WorkerFailedError`, and `EngineError` where the run is none.
    """
    try:
        answer = worker.play(scene, record, longest, settings)
    except WorkerAbsentError as error:
        raise EngineUnavailableError(f"engine `{engine}` can't start: {error}") from None
    if "cannot" in answer:
        raise UnsupportedSceneError(engine, (str(answer["cannot"]),))
    values: dict[str, Any] = answer | {"engine": engine, "scene": scene.name}
    return Run.parse(values, f"the answer of `{engine}`")


class WorkerEngine(EngineBase):
    """An engine that a script in `scripts/` drives in another interpreter."""

    MODULE: ClassVar[str]
    CAPABILITIES: ClassVar[ByConfiguration]

    @property
    def capabilities(self) -> Capabilities:
        """How each feature of a scene is represented."""
        return self.CAPABILITIES["always"]

    @classmethod
    def unavailable(cls) -> str | None:
        """Return how to get the interpreter, where it isn't there, or None."""
        if interpreter().is_file():
            return None
        return (
            "it runs in a separate Python interpreter, which isn't installed. Run `make peers` in "
            "a "
            f"checkout, or name one that has it: {PYTHON}=/path/to/python"
        )

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Have the worker play the scene."""
        self.check(scene)
        worker = _worker(self.MODULE, interpreter())
        return run_of(self.name, worker, scene, record, LONGEST).result(scene, record=record)


_ONE_AFTER_ANOTHER = (
    'no impacts = "simultaneous" where balls touch (it resolves one contact after another)'
)


def _frozen(scene: Scene) -> bool:
    """Whether two balls of a scene touch as it begins."""
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
            yield "no balls that always roll (its balls slide before they roll)"
        if scene.physics.impacts == "simultaneous" and _frozen(scene):
            yield _ONE_AFTER_ANOTHER

    def resolution(self, scene: Scene) -> float:  # noqa: ARG002
        """Return how far it moves balls at an impact [m]."""
        return 1e-6


class BilliardsEngine(WorkerEngine):
    """python-billiards: elastic discs without friction, from collision to collision."""

    name: ClassVar[str] = "billiards"
    Settings: ClassVar[type[EngineSettings]] = EngineSettings
    MODULE: ClassVar[str] = "billiards_peer"
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "billiards")

    def _lacking(self, scene: Scene) -> Iterator[str]:
        if np.any(scene.rolling_frictions != 0.0):
            yield "no friction of the cloth (its balls are never slowed)"
        if scene.t_max is None:
            yield "no shots to rest (its balls are never slowed: set `t_max`)"
        if scene.physics.impacts == "simultaneous" and _frozen(scene):
            yield _ONE_AFTER_ANOTHER

    def resolution(self, scene: Scene) -> float:  # noqa: ARG002
        """Return 0: it goes from collision to collision, and errs by rounding alone."""
        return 0.0
