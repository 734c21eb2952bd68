"""Running an engine, anyone's: the one door through which results come in.

Whatever an engine does is its own failure, and named so: it may raise, exit, crash, hang, or hand
back what no engine may.

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

NOT_BLAMED = (
    UnsupportedSceneError,
    EngineUnavailableError,
    EngineFailedError,
    NoCompilerError,  # what it says is what to install
)
"""What says of itself what is the matter, so that it is no engine's failure."""


@contextmanager
def blamed_on_engine(name: str) -> Iterator[None]:
    """Make whatever an engine raises in the block its failure, by name.

    What it says of a scene that it lacks something for, or of itself, stays as it is.
    """
    try:
        yield
    except NOT_BLAMED:
        raise
    except (Exception, SystemExit) as error:
        raise failure_of(name, error) from error


def failure_of(name: str, error: BaseException) -> EngineFailedError:
    """Return what an engine raised, or that what it returned is refused, as its failure."""
    if isinstance(error, ResultRefusedError) and name != OURS:
        return EngineFailedError(name, str(error))  # where we looked at it says nothing
    trace = "".join(traceback.format_exception(error))
    return EngineFailedError(name, f"{type(error).__name__}: {error}", trace)


def run_engine(engine: ReferenceEngine, scene: Scene, record: Record = "trajectory") -> Result:
    """Run a scene on an engine, and make sure that what it returns can be measured.

    Raises `UnsupportedSceneError` where the engine says that it can't represent the scene;
    `EngineFailedError` where it raises anything else, or what it returns breaks the contract of
    `Result`.
    """
    if isinstance(engine, _Remote):  # it comes through this door in the other process
        return engine.simulate(scene, record=record)
    with blamed_on_engine(engine.name):
        result = engine.simulate(scene, record=record)
        check_result(result, scene, engine.name, record)
    reason = storable(result.reason)
    return result if reason == result.reason else replace(result, reason=reason)


def first_played(engine: ReferenceEngine, scenes: Sequence[Scene]) -> str:
    """Return the name of the scene with the fewest balls that an engine supports; "" without one.

    `differs_by_record` is called for this scene alone, since it takes two more shots.
    """
    try:
        known = engine.capabilities
        played = [scene for scene in scenes if not missing_features(known, scene)]
    except Exception:  # its cases say what it raised
        return ""
    return min(played, key=lambda scene: len(scene.balls)).name if played else ""


def differs_by_record(engine: ReferenceEngine, result: Result) -> str:
    """Return how the result of a shot depends on what is recorded, in a sentence; "" if it doesn't.

    `result`: of the shot, recorded with its whole motion.

    Returns "" for an engine whose results differ from run to run, and for a function, which isn't
    told what to record.
    """
    if isinstance(engine, FunctionEngine) or not result.status.complete:
        return ""
    records: tuple[Record, ...] = ("rest", "events")
    for record in records:
        with captured():  # what it prints was reported with the shot itself
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

    What only one of them recorded isn't compared.
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
    """Yield the same engine, whose shots run in another process: a crash or a hang costs the shot.

    `time_limit` [s]: for each shot; None runs them in this process, which an engine that crashes
        then ends.
    `printed`: given what was printed during a shot, where that is anything; it is dropped
        otherwise.

    An engine that is made of the one yielded, with other settings, runs there too. The process ends
    with the block. Our own engine runs in this one: it is no stranger.
    """
    if type(engine) is GhostballEngine:  # a name anyone's class may have
        yield engine
        return
    base: Any = type(engine)
    with _Worker(base.__module__, time_limit, printed) as worker:

        class RemoteEngine(_Remote, base):  # type: ignore[misc]
            """The engine, but for where it runs."""

            def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
                """Run the scene in the other process; see `ReferenceEngine.simulate`."""
                return worker.run(_Shot(base, self.settings, scene, record))

        yield RemoteEngine(engine.settings)


class _Remote:
    """Base class of an engine that runs in another process.

    A class marks it, not an attribute: any engine may have an attribute of any name.
    """


@dataclass(frozen=True)
class _Shot:
    """What another process is asked to run."""

    engine: type[ReferenceEngine]
    settings: EngineSettings
    scene: Scene
    record: Record


@dataclass(frozen=True)
class _Answer:
    """A result, pickled, or the error that stands for it."""

    result: bytes = b""
    error: Exception | None = None


class _Worker:
    """One process that is asked for one shot after another."""

    def __init__(
        self, module: str, time_limit: float | None, printed: Callable[[str], None] | None
    ) -> None:
        self._waiting: deque[_Shot] = deque()
        self._printed = printed
        self._answers: Generator[Done[_Shot, _Answer]] = run_tasks(
            self, 1, _play, time_limit, partial(import_module, module)
        )

    def __iter__(self) -> Iterator[_Shot]:
        return self

    def __next__(self) -> _Shot:
        if not self._waiting:
            raise StopIteration
        return self._waiting.popleft()

    def __enter__(self) -> _Worker:
        return self

    def __exit__(self, *_: object) -> None:
        self._answers.close()

    def run(self, shot: _Shot) -> Result:
        self._waiting.append(shot)
        done = next(self._answers)
        if done.printed and self._printed is not None:
            self._printed(done.printed)
        answer = done.or_else(_crashed)
        if answer.error is not None:
            raise answer.error
        result: Result = pickle.loads(answer.result)
        return result


def _play(shot: _Shot) -> _Answer:
    name = shot.engine.name
    try:
        make: Any = shot.engine  # see `make_engine`
        with blamed_on_engine(name):
            engine = make(shot.settings)
            return _Answer(pickle.dumps(run_engine(engine, shot.scene, shot.record)))
    except NOT_BLAMED as error:
        return _Answer(error=_sendable(name, error))


def _sendable(name: str, error: Exception) -> Exception:
    """Return an error that can be sent to another process: one of an engine's own may not be."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return failure_of(name, error)
    return error


def _crashed(shot: _Shot, reason: str) -> _Answer:
    return _Answer(error=EngineFailedError(shot.engine.name, reason))
