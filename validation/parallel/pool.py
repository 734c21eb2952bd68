"""Work in several processes: a crash costs one task, an interrupt leaves no process behind.

A task that hangs costs no more than itself either, where it has a limit of time.

Nothing of what the tasks do is imported here: a process imports what its own tasks need.
"""

from __future__ import annotations

import faulthandler
import multiprocessing
import os
import signal
import tempfile
import threading
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import IO, Generic, TypeVar

from reference_adapters.output import captured, divert, flush, text_of

T = TypeVar("T")
R = TypeVar("R")

_JOIN_TIMEOUT = 5.0
"""Seconds that a terminated worker gets before it is killed."""

_START_LIMIT = 300.0
"""Seconds that a process gets to start and import, where tasks have a limit of time."""

_WAKE = 1.0
"""Seconds that we wait at a time.

Ctrl-C that comes between Python's last look for it and the wait, or that another thread is given,
is seen only when the wait ends.
"""

_ORPHANED = 1
"""Exit code of a process whose parent is gone."""

# Not fork: pybullet's and numba's threads and locks don't survive it.
_CONTEXT = multiprocessing.get_context("spawn")


@dataclass(eq=False)
class _Worker(Generic[T]):
    process: SpawnProcess
    connection: Connection
    path: str  # of the file that it prints into
    output: IO[bytes]
    task: T | None = None
    started: bool = False  # it has imported what it needs
    deadline: float | None = None  # of the task, in seconds of the monotonic clock


def limit_of(seconds: float | None) -> Callable[[object], float] | None:
    """Return the `limit` of `run_tasks` that is the same for every task; None for none."""
    return None if seconds is None else lambda _: seconds


def run_tasks(
    tasks: Iterable[T],
    jobs: int,
    work: Callable[[T], R],
    died: Callable[[T, str], R],
    limit: Callable[[T], float] | None = None,
    printed: Callable[[T, str], None] | None = None,
    prepare: Callable[[], object] | None = None,
) -> Generator[R]:
    """Do tasks in `jobs` processes; yield what each gives.

    In this very process where `jobs` is 1 and there is no limit. Nothing that a task prints reaches
    our own standard output or, from another process, standard error.

    Parameters
    ----------
    tasks : iterable
        Taken one by one, as processes become free.
    jobs : int
    work : callable
        Does a task; a function of a module, for other processes must find it.
    died : callable
        Given a task and why its process died of it; what it returns is yielded instead.
    limit : callable, optional
        How long a task may take [s]: after that its process is ended, and it has died of it. The
        start of a process doesn't count; that has a limit of its own, of minutes.
    printed : callable, optional
        Given a task and what was printed while it was done, where that is anything, before what the
        task gives is yielded; it is dropped otherwise.
    prepare : callable, optional
        What another process does first, such as importing what tasks need: no task's limit of time
        runs meanwhile. What it is made of is found before that process can divert what is printed:
        it should name what it imports.

    Notes
    -----
    Close the generator to stop early: its processes are gone when `close` returns.
    """
    if jobs == 1 and limit is None:
        for task in tasks:
            with captured() as output:
                given = work(task)
            if output.text and printed is not None:
                printed(task, output.text)
            yield given
        return
    pool = _Pool(jobs, work, died, limit, printed, prepare)
    queue = iter(tasks)
    try:
        while True:
            pool.hand_out(queue)
            if not pool.is_busy:
                return
            yield from pool.collect()
    finally:
        pool.close()


class _Pool(Generic[T, R]):
    """Processes, each at one task or waiting for one."""

    def __init__(
        self,
        jobs: int,
        work: Callable[[T], R],
        died: Callable[[T, str], R],
        limit: Callable[[T], float] | None,
        printed: Callable[[T, str], None] | None,
        prepare: Callable[[], object] | None,
    ) -> None:
        self._jobs = jobs
        self._serve = partial(_serve, work, prepare)
        self._died = died
        self._limit = limit
        self._printed = printed
        self._workers: list[_Worker[T]] = []

    @property
    def is_busy(self) -> bool:
        return any(worker.task is not None for worker in self._workers)

    def hand_out(self, queue: Iterator[T]) -> None:
        """Give every idle process a task, starting processes up to their number."""
        while True:
            idle = next((worker for worker in self._workers if worker.task is None), None)
            if idle is None and len(self._workers) == self._jobs:
                return
            task = next(queue, None)
            if task is None:
                return
            if idle is None or not self._sent(idle, task):
                fresh = self._started()
                with suppress(ConnectionError):  # it died at once: `collect` reports the task
                    self._give(fresh, task)

    def _sent(self, idle: _Worker[T], task: T) -> bool:
        """Give an idle process a task; whether it was alive to take it."""
        # It may have died since its last task, of what that left behind: this one isn't to blame.
        if idle.process.is_alive():
            try:
                self._give(idle, task)
            except ConnectionError:
                pass
            else:
                return True
        self._workers.remove(idle)
        _bury(idle)
        return False

    def _started(self) -> _Worker[T]:
        worker: _Worker[T] = _start(self._serve)
        self._workers.append(worker)
        return worker

    def _give(self, worker: _Worker[T], task: T) -> None:
        worker.task = task
        self._begin(worker)
        os.ftruncate(worker.output.fileno(), 0)  # of the task before
        worker.connection.send(task)

    def collect(self) -> Iterator[R]:
        """Wait until something happens, and yield what tasks gave that have ended."""
        busy = [worker for worker in self._workers if worker.task is not None]
        ready = wait([worker.connection for worker in busy], self._patience(busy))
        for worker in busy:
            assert worker.task is not None
            # Asked again: while what others gave was taken, this one may have answered too.
            if worker.connection not in ready and not worker.connection.poll():
                if worker.deadline is not None and time.monotonic() >= worker.deadline:
                    assert self._limit is not None
                    yield self._give_up(
                        worker,
                        f"it took longer than {self._limit(worker.task):g} s, and was ended"
                        if worker.started
                        else f"its process did not start within {_START_LIMIT:g} s",
                    )
                continue
            try:
                message = worker.connection.recv()
            except (EOFError, OSError):  # OSError: killed in the midst of an answer
                worker.process.join(_JOIN_TIMEOUT)
                code = worker.process.exitcode
                yield self._give_up(worker, f"the process running it died (exit code {code})")
                continue
            if not worker.started:
                worker.started = True
                self._begin(worker)
            else:
                self._tell_printed(worker)
                worker.task = worker.deadline = None
                yield message

    def close(self) -> None:
        """End all processes, whatever they do."""
        for worker in self._workers:
            worker.process.terminate()
        for worker in self._workers:
            _bury(worker)

    def _begin(self, worker: _Worker[T]) -> None:
        """Let the time of a task run, or, until its process has started, that of the start."""
        if self._limit is not None and worker.task is not None:
            limit = self._limit(worker.task) if worker.started else _START_LIMIT
            worker.deadline = time.monotonic() + limit

    def _patience(self, busy: list[_Worker[T]]) -> float:
        """Return the time to wait at most: until the first deadline, where one comes soon."""
        deadlines = [worker.deadline for worker in busy if worker.deadline is not None]
        return max(0.0, min([_WAKE, *(at - time.monotonic() for at in deadlines)]))

    def _give_up(self, worker: _Worker[T], reason: str) -> R:
        task = worker.task
        assert task is not None
        self._workers.remove(worker)
        worker.process.terminate()
        worker.process.join(_JOIN_TIMEOUT)
        self._tell_printed(worker)
        _bury(worker)
        return self._died(task, reason)

    def _tell_printed(self, worker: _Worker[T]) -> None:
        """Hand on what a worker's task printed, where it did and somebody asks."""
        if self._printed is not None and worker.task is not None:
            text = text_of(worker.output)
            if text:
                self._printed(worker.task, text)


def _start(serve: Callable[[Connection, str], None]) -> _Worker[T]:
    ours, theirs = _CONTEXT.Pipe()
    file, path = tempfile.mkstemp(prefix="ghostball-")
    process = _CONTEXT.Process(target=serve, args=(theirs, path), daemon=True)
    with _interrupts_held():
        process.start()
    theirs.close()  # so that `recv` ends when the process does
    return _Worker(process, ours, path, os.fdopen(file, "r+b", buffering=0))


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Hold Ctrl-C back for a moment; it takes effect at the end.

    A process started meanwhile inherits the hold, and so is deaf to Ctrl-C from its first
    instruction on, not only once it has imported everything and gets to say so itself.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    # Its start lets interrupts through again, so it must not be the first process that starts it.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _bury(worker: _Worker[T]) -> None:
    worker.process.join(_JOIN_TIMEOUT)
    if worker.process.is_alive():
        worker.process.kill()
        worker.process.join()
    worker.connection.close()
    worker.output.close()
    with suppress(OSError):
        os.unlink(worker.path)


def _serve(
    work: Callable[[T], R],
    prepare: Callable[[], object] | None,
    connection: Connection,
    output: str,
) -> None:
    """Do tasks until the other end closes: the body of a worker process."""
    divert(output)
    faulthandler.enable(all_threads=False)  # a crash then says where, into what is printed
    # Ctrl-C reaches the whole group; the parent alone decides what happens then. POSIX workers
    # are deaf already, see `_interrupts_held`.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    if prepare is not None:
        prepare()
    with closing(connection):
        if not _told(connection, "started"):
            return
        while True:
            try:
                task = connection.recv()
            except (EOFError, ConnectionError):
                return
            given = work(task)
            flush()
            if not _told(connection, given):
                return


def _told(connection: Connection, message: object) -> bool:
    """Send a message; whether anyone is there to get it."""
    try:
        connection.send(message)
    except ConnectionError:  # the parent was killed, and has nobody left to tell of it
        return False
    return True


def _end_with_parent() -> None:
    """End this process once its parent is gone, also in the midst of a task that hangs."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    wait([parent.sentinel])
    os._exit(_ORPHANED)
