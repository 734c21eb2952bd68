"""Run any engine and check its result; every result enters through this module.

Whatever an engine does wrong is reported as its failure: it may raise, exit, crash, hang, or return
an invalid result.

    >>> with in_other_process(make_engine("pymunk"), time_limit=60.0) as engine:
    ...     result = run_engine(engine, scene)
"""

from __future__ import annotations

import pickle
import traceback
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from typing import Any

import numpy as np

from ghostball.engine import simulate
from ghostball.engine.library.load import NoCompilerError
from ghostball.model import EngineFailedError, Record, Result, Scene, UnsupportedSceneError
from ghostball.model.errors import storable
from ghostball.model.features import missing_features
from ghostball.reference_adapters.base import EngineSettings, ReferenceEngine
from ghostball.reference_adapters.function import FunctionEngine
from ghostball.reference_adapters.ghostball import GhostballEngine
from ghostball.reference_adapters.output import captured
from ghostball.reference_adapters.registry import OURS, EngineUnavailableError
from ghostball.reference_adapters.returned import ResultRefusedError, check_result
from ghostball.validation.parallel.pool import Done, run_tasks

SELF_EXPLAINED = (
    UnsupportedSceneError,
    EngineUnavailableError,
    EngineFailedError,
    NoCompilerError,  # its message states what to install
)
"""Errors that explain themselves, so they don't count as failures of an engine."""


@contextmanager
def blamed_on_engine(name: str) -> Iterator[None]:
    """Turn any exception in the block into an `EngineFailedError` with the name of the engine.

    The errors in `SELF_EXPLAINED`, such as an unsupported scene, pass unchanged.
    """
    try:
        yield
    except SELF_EXPLAINED:
        raise
    except (Exception, SystemExit) as error:
        raise failure_of(name, error) from error


def failure_of(name: str, error: BaseException) -> EngineFailedError:
    """Return an exception of an engine, or the refusal of its result, as `EngineFailedError`."""
    if isinstance(error, ResultRefusedError) and name != OURS:
        return EngineFailedError(name, str(error))  # a traceback of the check doesn't help
    trace = "".join(traceback.format_exception(error))
    return EngineFailedError(name, f"{type(error).__name__}: {error}", trace)


def run_engine(engine: ReferenceEngine, scene: Scene, record: Record = "trajectory") -> Result:
    """Run a scene on an engine, and check that its result can be measured.

    Raises `UnsupportedSceneError` if the engine doesn't support the scene; `EngineFailedError` if
    it raises anything else, or if its result breaks the contract of `Result`.
    """
    if isinstance(engine, _Remote):  # checked in the other process
        return engine.simulate(scene, record=record)
    with blamed_on_engine(engine.name):
        result = engine.simulate(scene, record=record)
        check_result(result, scene, engine.name, record)
    reason = storable(result.reason)
    return result if reason == result.reason else replace(result, reason=reason)


def smallest_supported(engine: ReferenceEngine, scenes: Sequence[Scene]) -> str:
    """Return the supported scene with the fewest balls, by name; "" if there is none.

    `differs_by_record` is called for this scene only, because it takes two more runs.
    """
    try:
        known = engine.capabilities
        played = [scene for scene in scenes if not missing_features(known, scene)]
    except Exception:  # the cases of this engine report the error
        return ""
    return min(played, key=lambda scene: len(scene.balls)).name if played else ""


def differs_by_record(engine: ReferenceEngine, result: Result) -> str:
    """Return how the result of a shot depends on what is recorded, in a sentence; "" if it doesn't.

    `result`: of the shot, recorded with its whole motion.

    Returns "" for an engine with results that differ from run to run, and for a function, which
    doesn't know what to record.
    """
    if isinstance(engine, FunctionEngine) or not result.status.complete:
        return ""
    records: tuple[Record, ...] = ("rest", "events")
    for record in records:
        with captured():  # its output was reported with the first run
            found = _difference(result, run_engine(engine, result.scene, record))
            found = "" if found and _difference(result, run_engine(engine, result.scene)) else found
        if found:
            return (
                f'its result depends on what is recorded: {found} between `record="{record}"` '
                'and `record="trajectory"`. Make it independent of `record`'
            )
    return ""


def _difference(one: Result, other: Result) -> str:
    """Return the first difference of two results of a shot, to the bit; "" if there is none.

    Parts that only one of them recorded aren't compared.
    """
    if one.status is not other.status:
        return f"`status` differs ({other.status.value} and {one.status.value})"
    if not np.array_equal(one.rest_positions, other.rest_positions):
        off = np.max(np.linalg.norm(other.rest_positions - one.rest_positions, axis=1))
        return f"`rest_positions` differ by {off:.3g} m"
    if one.rest_time != other.rest_time:
        return f"`rest_time` differs by {abs(other.rest_time - one.rest_time):.3g} s"
    if dict(one.collision_counts) != dict(other.collision_counts):
        counts = f"{dict(other.collision_counts)} and {dict(one.collision_counts)}"
        return f"`collision_counts` differ ({counts})"
    if one.events is None or other.events is None:
        return ""
    return "" if np.array_equal(one.events, other.events) else "`events` differ"


def run_ours(scene: Scene, record: Record = "trajectory") -> Result:
    """Run a scene on Ghostball's engine, with its whole motion unless `record` asks for less.

    Raises `UnsupportedSceneError` if the engine doesn't support the scene.
    """
    return simulate(scene, record=record)


@contextmanager
def in_other_process(
    engine: ReferenceEngine,
    time_limit: float | None,
    printed: Callable[[str], None] | None = None,
) -> Iterator[ReferenceEngine]:
    """Yield the same engine, with its shots in another process: a crash or a hang loses one shot.

    `time_limit` [s]: for each shot; None runs the shots in this process, which a crash then ends.
    `printed`: called with the output of a shot, if there is any; without it the output is dropped.

    Engines that the block creates from the yielded engine with other settings run there, too. The
    process ends with the block. Ghostball's engine always runs in this process, because it is
    trusted.
    """
    if type(engine) is GhostballEngine:  # another class may have the same `name`
        yield engine
        return
    base: Any = type(engine)
    with _RemoteWorker(base.__module__, time_limit, printed) as worker:

        class RemoteEngine(_Remote, base):  # type: ignore[misc]
            """The engine, running in another process."""

            def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
                """Run the scene in the other process; see `ReferenceEngine.simulate`."""
                return worker.run(_RemoteShot(base, self.settings, scene, record))

        yield RemoteEngine(engine.settings)


class _Remote:
    """Marks an engine that runs in another process.

    It is a base class, not an attribute, because an engine may have attributes of any name.
    """


@dataclass(frozen=True)
class _RemoteShot:
    """A shot that another process is asked to run."""

    engine: type[ReferenceEngine]
    settings: EngineSettings
    scene: Scene
    record: Record


@dataclass(frozen=True)
class _RemoteAnswer:
    """A pickled result, or the error in its place."""

    result: bytes = b""
    error: Exception | None = None


class _RemoteWorker:
    """A process that runs one shot after another."""

    def __init__(
        self, module: str, time_limit: float | None, printed: Callable[[str], None] | None
    ) -> None:
        self._waiting: deque[_RemoteShot] = deque()
        self._printed = printed
        self._answers: Generator[Done[_RemoteShot, _RemoteAnswer]] = run_tasks(
            self, 1, _play, time_limit, partial(import_module, module)
        )

    def __iter__(self) -> Iterator[_RemoteShot]:
        return self

    def __next__(self) -> _RemoteShot:
        if not self._waiting:
            raise StopIteration
        return self._waiting.popleft()

    def __enter__(self) -> _RemoteWorker:
        return self

    def __exit__(self, *_: object) -> None:
        self._answers.close()

    def run(self, shot: _RemoteShot) -> Result:
        self._waiting.append(shot)
        done = next(self._answers)
        if done.printed and self._printed is not None:
            self._printed(done.printed)
        answer = done.or_else(_crashed)
        if answer.error is not None:
            raise answer.error
        result: Result = pickle.loads(answer.result)
        return result


def _play(shot: _RemoteShot) -> _RemoteAnswer:
    name = shot.engine.name
    try:
        make: Any = shot.engine  # see `make_engine`
        with blamed_on_engine(name):
            engine = make(shot.settings)
            return _RemoteAnswer(pickle.dumps(run_engine(engine, shot.scene, shot.record)))
    except SELF_EXPLAINED as error:
        return _RemoteAnswer(error=_sendable(name, error))


def _sendable(name: str, error: Exception) -> Exception:
    """Return an error that can be pickled; an engine's own exception class may prevent this."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return failure_of(name, error)
    return error


def _crashed(shot: _RemoteShot, reason: str) -> _RemoteAnswer:
    return _RemoteAnswer(error=EngineFailedError(shot.engine.name, reason))
