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
from ghostball.model.features import EXACT, Capabilities, Capability, Feature
from ghostball.reference_adapters.base import EngineBase, EngineSettings, none
from ghostball.reference_adapters.elsewhere import Run
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

    @classmethod
    def unavailable(cls) -> str | None:
        """Return how to get the interpreter, where it isn't there, or None."""
        if interpreter().is_file():
            return None
        return (
            "it runs in an interpreter of its own, which isn't there. Run `make peers` in a "
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

    @property
    def capabilities(self) -> Capabilities:
        """How each feature of a scene is represented."""
        moved = Capability(
            "approximate", "exact, but that balls are moved 1 um apart at each impact"
        )
        lines = none("driven here with rectangles")
        one = none("pooltool has one number of each kind for all balls here")
        no_law = none("driven here with mirrors and Han's cushions alone")
        return {
            Feature.ROLLING: EXACT,
            Feature.SLIDING: EXACT,
            Feature.FRICTIONLESS_CLOTH: Capability(
                "approximate", "its frictions must be more than 0: 1e-9 stands for none"
            ),
            Feature.VERTICAL_SPIN: EXACT,
            Feature.BALL_RESTITUTION: moved,
            Feature.BALL_FRICTION: moved,
            Feature.SPEED_DEPENDENT_FRICTION: moved,
            Feature.MATHAVAN_BALL: none("driven here with its frictional, inelastic impacts"),
            Feature.UNEQUAL_MASSES: one,
            Feature.UNEQUAL_RADII: one,
            Feature.PER_BALL_FRICTION: one,
            Feature.UNBOUNDED_CLOTH: Capability("approximate", "on a table of 1 km"),
            Feature.OPEN_SIDES: none("its tables have all four cushions here"),
            Feature.POLYGON: lines,
            Feature.POCKETS: lines,
            Feature.POSTS: lines,
            Feature.MIRROR_CUSHION: moved,
            Feature.CUSHION_RESTITUTION: no_law,
            Feature.FALLING_RESTITUTION: none("pooltool's restitution is one at any speed"),
            Feature.CUSHION_TANGENTIAL: no_law,
            Feature.FRICTIONAL_CUSHION: no_law,
            Feature.HAN_CUSHION: moved,
            Feature.MATHAVAN_CUSHION: no_law,
            Feature.AIR_DRAG: none("pooltool has no air"),
            Feature.QUADRATIC_ROLLING: none("pooltool's rolling friction is one at any speed"),
            Feature.FLIGHT: none("pooltool's balls never leave the cloth"),
        }

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

    @property
    def capabilities(self) -> Capabilities:
        """How each feature of a scene is represented."""
        elastic = none("its impacts are elastic, and without friction")
        lines = none("driven here with rectangles")
        cloth = none("it has no cloth: its balls are never slowed")
        return {
            Feature.ROLLING: Capability("approximate", "where nothing slows them"),
            Feature.SLIDING: cloth,
            Feature.FRICTIONLESS_CLOTH: EXACT,
            Feature.VERTICAL_SPIN: cloth,
            Feature.BALL_RESTITUTION: elastic,
            Feature.BALL_FRICTION: elastic,
            Feature.SPEED_DEPENDENT_FRICTION: elastic,
            Feature.MATHAVAN_BALL: elastic,
            Feature.UNEQUAL_MASSES: EXACT,
            Feature.UNEQUAL_RADII: EXACT,
            Feature.PER_BALL_FRICTION: cloth,
            Feature.UNBOUNDED_CLOTH: EXACT,
            Feature.OPEN_SIDES: EXACT,
            Feature.POLYGON: lines,
            Feature.POCKETS: lines,
            Feature.POSTS: lines,
            Feature.MIRROR_CUSHION: EXACT,
            Feature.CUSHION_RESTITUTION: elastic,
            Feature.FALLING_RESTITUTION: elastic,
            Feature.CUSHION_TANGENTIAL: elastic,
            Feature.FRICTIONAL_CUSHION: elastic,
            Feature.HAN_CUSHION: elastic,
            Feature.MATHAVAN_CUSHION: elastic,
            Feature.AIR_DRAG: cloth,
            Feature.QUADRATIC_ROLLING: cloth,
            Feature.FLIGHT: cloth,
        }

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
