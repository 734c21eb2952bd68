"""Run tasks on the workers of a Dask cluster; `distributed` is an optional dependency.

A worker of the cluster runs each task in a separate process, as this machine would: a crash loses
one task and is reported, a task has its time limit, and its output is kept. If a worker itself is
killed, another worker repeats its tasks. A task is ended if nobody waits for its result, because
the run was interrupted or killed.
"""

from __future__ import annotations

import asyncio
import logging
import math
import multiprocessing
import pickle
import threading
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from itertools import islice
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, TypeVar
from uuid import uuid4

from ghostball.model import GhostballError
from ghostball.reference_adapters.registry import EngineUnavailableError
from ghostball.validation.parallel.pool import LONGEST_WAIT, Done, Process, one_kind, wait
from ghostball.validation.parallel.sources import code_here, engine_code, engine_source

if TYPE_CHECKING:
    from distributed import Client, Future

T = TypeVar("T")
R = TypeVar("R")

CONNECT_LIMIT = 10.0
"""Time [s] after which a scheduler that doesn't answer counts as unreachable."""

WORKERLESS_LIMIT = 60.0
"""Time [s] that a cluster may be without a worker."""

_START_LIMIT = 3600.0
"""Time limit [s] for the start of a process, which may have to compile all kernels."""

_FETCH_LIMIT = 30.0
"""Time limit [s] for fetching a result; then it is requested again, since its worker may be lost.
"""

_IDLE_LIMIT = 60.0
"""Time [s] after which a worker ends an idle process."""


_LOGGERS = ("distributed", "distributed.client", "tornado.application")
"""Loggers to which Dask assigns their own level."""


_Answer = Done[None, bytes]
"""The answer of a task, with its result pickled; only the caller unpickles it."""


class ClusterError(GhostballError):
    """A cluster that can't be used: not installed, unreachable, or with other code versions."""


class ClusterLostError(ClusterError):
    """A cluster that was lost while it ran tasks."""


@contextmanager
def cluster_at(address: str | None) -> Iterator[Cluster | None]:
    """Connect to the scheduler of a Dask cluster while the block runs.

    `address`: such as tcp://10.0.0.1:8786; None: no cluster.

    Raises `ClusterError` if Dask isn't installed, or if no scheduler answers.
    """
    if address is None:
        yield None
        return
    try:
        from distributed import Client  # noqa: PLC0415 - optional, and takes half a second
    except ImportError:
        raise ClusterError(
            "a cluster needs Dask, which isn't installed here: run pip install '.[cluster]' in a "
            "clone of Ghostball"
        ) from None
    # Errors are reported once, by Ghostball.
    levels = {logging.getLogger(name): logging.getLogger(name).level for name in _LOGGERS}
    for logger in levels:
        logger.setLevel(logging.CRITICAL)
    try:
        try:
            with ThreadPoolExecutor(1) as thread:  # this thread may have an event loop
                found = thread.submit(asyncio.run, _what_answers(address)).result()
            if found != "Scheduler":
                raise ValueError(f"a {found.lower()} answers")
            client = Client(address, timeout=CONNECT_LIMIT, set_as_default=False)
        except Exception as error:
            why = str(error) or f"no answer within {CONNECT_LIMIT:g} s"
            raise ClusterError(
                f"no Dask scheduler can be reached at {address!r}: {why}. Use the address that "
                "`dask scheduler` prints"
                ", such as tcp://10.0.0.1:8786"
            ) from error
        try:
            yield Cluster(client, address)
        finally:
            with suppress(Exception):  # the cluster may be gone
                client.close(timeout=LONGEST_WAIT)
    finally:
        for logger, level in levels.items():
            logger.setLevel(level)


async def _what_answers(address: str) -> str:
    """Return the type of server at an address: a Dask client waits forever for the wrong type."""
    from distributed import Security, rpc  # noqa: PLC0415

    secrets = Security().get_connection_args("client")
    async with rpc(address, connection_args=secrets, timeout=CONNECT_LIMIT) as there:
        identity = await asyncio.wait_for(there.identity(), CONNECT_LIMIT)
    return str(identity["type"])


class Cluster:
    """A cluster that runs as many tasks at once as its workers have threads."""

    def __init__(self, client: Client, address: str) -> None:
        self._client, self._address = client, address
        self._threads, self._asked = 0, -math.inf
        self._alone_since: float | None = None

    def run_tasks(
        self,
        tasks: Iterable[T],
        work: Callable[[T], R],
        limit: Callable[[T], float] | None = None,
        prepare: Callable[[], object] | None = None,
        kind: Callable[[T], str] = one_kind,
    ) -> Generator[Done[T, R]]:
        """Run tasks and yield the result of each; see `validation.parallel.pool.run_tasks`.

        Raises `ClusterError` if a worker lacks the code of Ghostball or of an engine, or has
        another version; `ClusterLostError` if the scheduler ends, or if there is no worker for a
        minute.
        """

        @cache
        def first_of(one: str) -> bytes:
            given = code_here() | _engine_here(one), one, pickle.dumps(prepare)
            return pickle.dumps((_first, given))

        run = uuid4().hex
        queue = iter(tasks)
        doing: dict[str, tuple[Future, T]] = {}
        done: SimpleQueue[Future] = SimpleQueue()
        try:
            while True:
                for task in islice(queue, max(0, self._room() - len(doing))):
                    key = f"ghostball-{uuid4().hex}"
                    seconds = None if limit is None else limit(task)
                    one = kind(task)
                    first, does = first_of(one), pickle.dumps((work, task))
                    job = _Job((f"{run} {one}", first, key, does, seconds))
                    with self._answering():
                        future = self._client.submit(pickle.loads, pickle.dumps(job), key=key)
                        future.add_done_callback(done.put)
                    doing[key] = future, task
                if not doing:
                    return
                try:
                    future = done.get(timeout=LONGEST_WAIT)
                except Empty:
                    continue
                with self._answering():
                    answer = self._answer(future)
                    if answer is None:
                        future.add_done_callback(done.put)
                        continue
                _, task = doing.pop(future.key)
                yield answer.of(task)
        finally:
            # Workers end running tasks that nobody waits for.
            with suppress(Exception):  # the cluster may be gone
                self._client.cancel([future for future, _ in doing.values()], force=True)

    def _room(self) -> int:
        """Return how many tasks can run at once; at least 1, which then waits for a worker."""
        now = time.monotonic()
        with self._answering():
            if self._client.status != "running":
                raise ConnectionError
            if now - self._asked >= LONGEST_WAIT:
                self._threads, self._asked = sum(self._client.nthreads().values()), now
        if self._threads:
            self._alone_since = None
        elif self._alone_since is None:
            self._alone_since = now
        elif now - self._alone_since > WORKERLESS_LIMIT:
            raise ClusterLostError(
                self._lost(f"no worker has been available for {WORKERLESS_LIMIT:g} s")
            )
        return max(1, self._threads)

    def _answer(self, future: Future) -> _Answer | None:
        """Return the answer of a finished task; None if it has to be waited for again."""
        from distributed import KilledWorker  # noqa: PLC0415

        if future.status in ("cancelled", "lost"):
            raise ConnectionError
        if future.status == "error":
            error = future.exception(timeout=_FETCH_LIMIT)
            if isinstance(error, KilledWorker):
                workers = error.allowed_failures + 1
                return Done(
                    None, None, f"it ended {workers} workers of the cluster, one by one", ""
                )
            if isinstance(error, ClusterError):
                raise ClusterError(
                    f"a worker of the cluster at {self._address} has a different version of the "
                    f"code: {error}. Install the same version there"
                ) from error
            # such as a module of Ghostball that the worker can't import
            while error.__cause__ is not None:
                error = error.__cause__
            why = " ".join(str(error).split())
            raise ClusterError(
                f"the cluster at {self._address} can't run Ghostball: {type(error).__name__}: "
                f"{why}. Install the same version of Ghostball on its workers"
            ) from error
        try:
            answer: _Answer = future.result(timeout=_FETCH_LIMIT)
        except TimeoutError:
            return None
        return answer

    @contextmanager
    def _answering(self) -> Iterator[None]:
        """Call the scheduler in the block.

        Raises `ClusterLostError` if it doesn't answer.
        """
        try:
            yield
        except (OSError, asyncio.CancelledError) as error:
            why = self._lost("its scheduler no longer answers")
            raise ClusterLostError(why) from error

    def _lost(self, why: str) -> str:
        return (
            f"lost the cluster at {self._address}: {why}. Finished cases are stored: run the same "
            "command to continue"
        )


@dataclass(frozen=True)
class _Job:
    """A task in the form that a worker receives: `pickle.loads` runs it; see `serve`.

    The worker itself thus needs only the standard library, and a worker without Ghostball, or with
    another version, can report this: an unreadable task would end the worker.
    """

    given: tuple[str, bytes, str, bytes, float | None]

    def __reduce__(self) -> Any:
        return serve, self.given


def _engine_here(name: str) -> dict[str, str]:
    """Return the code of an engine, or the reason why it can't be imported, for a comparison."""
    try:
        return engine_code(name)
    except EngineUnavailableError as error:
        return {engine_source(name): f"missing ({error})"}


def _first(given: tuple[dict[str, str], str, bytes]) -> str:
    """Prepare this process for tasks; return the differences of its code, or ""."""
    wanted, engine, prepare = given
    here = code_here() | _engine_here(engine)
    differences = [
        f"{name} is {here.get(name, 'missing')} there and {wanted.get(name, 'missing')} here"
        for name in {**wanted, **here}
        if here.get(name) != wanted.get(name)
    ]
    if not differences and (found := pickle.loads(prepare)) is not None:
        found()
    return ", ".join(differences)


_LOCK = threading.Lock()
_IDLE: dict[Process, tuple[str, threading.Timer]] = {}
"""Idle processes of this worker: for each, its run and the timer that will end it."""


def serve(run: str, first: bytes, key: str, pickled: bytes, limit: float | None) -> _Answer:
    """Run a task in a process of this worker.

    `run`: the run and the kind of the task; an idle process of the same run and kind is reused.
    `first`: `_first` and its argument, pickled: what a new process does before its first task.
    `key`: Dask's key of the task.
    `pickled`: the function and the task, pickled.
    `limit` [s]: time limit of the task.

    Raises `ClusterError` if the code on this worker differs.
    """
    process = _idle_process(run)
    is_new = process is None
    process = process or _new_process()
    with ExitStack() as ending:
        ending.callback(process.close)
        if is_new:
            answer = _answered(process, key, first, _START_LIMIT)
            if answer.crashed:
                return answer
            if differences := answer.of(None).given:
                raise ClusterError(differences)
        answer = _answered(process, key, pickled, limit)
        if answer.crashed:
            return answer
        ending.pop_all()
    _keep(process, run)
    return answer


def _answered(process: Process, key: str, pickled: bytes, limit: float | None) -> _Answer:
    from distributed import get_worker  # noqa: PLC0415

    tasks = get_worker().state.tasks
    process.give(pickled, limit)
    while (answer := process.answer()) is None:
        wait([process])
        if key not in tasks or tasks[key].state == "cancelled":
            return Done(None, None, "nobody waits for it any more", "")
    return answer


def _new_process() -> Process:
    # Workers are daemonic, so they may not start processes, which could outlive them. The processes
    # of Ghostball end with their parent.
    multiprocessing.current_process()._config["daemon"] = False  # type: ignore[attr-defined]
    return Process(pickle.dumps((None, None)), _START_LIMIT)


def _idle_process(run: str) -> Process | None:
    with _LOCK:
        found = next(
            (one for one, (name, _) in _IDLE.items() if name == run and one.is_alive), None
        )
        if found is not None:
            _IDLE.pop(found)[1].cancel()
        return found


def _keep(process: Process, run: str) -> None:
    """Keep a process for the next task of its run, until `_IDLE_LIMIT` has passed."""
    timer = threading.Timer(_IDLE_LIMIT, _end, [process])
    timer.daemon = True
    with _LOCK:
        _IDLE[process] = run, timer
        timer.start()


def _end(process: Process) -> None:
    with _LOCK:
        idle = _IDLE.pop(process, None) is not None
    if idle:
        process.close()
