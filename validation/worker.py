"""Work in several processes: a crash costs one task, an interrupt leaves no process behind."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import Generic, TypeVar

from validation.case import Case, blank_record, failed, run_case
from validation.records import CaseRecord, Motion

Finished = tuple[CaseRecord, Motion | None]

T = TypeVar("T")
R = TypeVar("R")

_JOIN_TIMEOUT = 5.0
"""Seconds that a terminated worker gets before it is killed."""

# Not fork: pybullet's and numba's threads and locks don't survive it.
_CONTEXT = multiprocessing.get_context("spawn")


@dataclass(eq=False)
class _Worker(Generic[T]):
    process: SpawnProcess
    connection: Connection
    task: T | None = None


def run_cases(cases: Iterable[Case], jobs: int) -> Generator[Finished]:
    """Run cases in `jobs` processes, or in this one where it is 1; yield each as it ends.

    Parameters and notes are those of `run_tasks`.
    """
    return run_tasks(cases, jobs, run_case, _died)


def run_tasks(
    tasks: Iterable[T], jobs: int, work: Callable[[T], R], died: Callable[[T, str], R]
) -> Generator[R]:
    """Do tasks in `jobs` processes, or in this one where it is 1; yield what each gives.

    Parameters
    ----------
    tasks : iterable
        Taken one by one, as processes become free.
    jobs : int
    work : callable
        Does a task; a function of a module, for other processes must find it.
    died : callable
        Given a task and why its process died of it; what it returns is yielded instead.

    Notes
    -----
    Close the generator to stop early: its processes are gone when `close` returns.
    """
    if jobs == 1:
        yield from map(work, tasks)
        return
    queue = iter(tasks)
    workers: list[_Worker[T]] = []
    try:
        while True:
            _hand_out(queue, workers, jobs, partial(_serve, work))
            busy = [worker for worker in workers if worker.task is not None]
            if not busy:
                return
            ready = wait([worker.connection for worker in busy])
            for worker in busy:
                if worker.connection in ready:
                    yield _collect(worker, workers, died)
    finally:
        for worker in workers:
            worker.process.terminate()
        for worker in workers:
            _bury(worker)


def _died(case: Case, reason: str) -> Finished:
    return failed(blank_record(case), reason), None


def _hand_out(
    queue: Iterator[T], workers: list[_Worker[T]], jobs: int, serve: Callable[[Connection], None]
) -> None:
    """Give every idle process a task, starting processes up to `jobs`."""
    while True:
        idle = next((worker for worker in workers if worker.task is None), None)
        if idle is None and len(workers) == jobs:
            return
        task = next(queue, None)
        if task is None:
            return
        if idle is None:
            idle = _start(serve)
            workers.append(idle)
        idle.task = task
        with suppress(BrokenPipeError):  # it died while idle: `_collect` reports the task
            idle.connection.send(task)


def _collect(worker: _Worker[T], workers: list[_Worker[T]], died: Callable[[T, str], R]) -> R:
    """Take what a process made of its task, or note that the process died of it."""
    task = worker.task
    assert task is not None
    try:
        finished: R = worker.connection.recv()
    except (EOFError, ConnectionResetError):
        workers.remove(worker)
        _bury(worker)
        return died(task, f"the process running it died (exit code {worker.process.exitcode})")
    worker.task = None
    return finished


def _start(serve: Callable[[Connection], None]) -> _Worker[T]:
    ours, theirs = _CONTEXT.Pipe()
    process = _CONTEXT.Process(target=serve, args=(theirs,), daemon=True)
    with _interrupts_held():
        process.start()
    theirs.close()  # so that `recv` ends when the process does
    return _Worker(process, ours)


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Hold Ctrl-C back for a moment; it takes effect at the end.

    A process started meanwhile inherits the hold, and so is deaf to Ctrl-C from its first
    instruction on, not only once it has imported everything and gets to say so itself.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
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


def _serve(work: Callable[[T], R], connection: Connection) -> None:
    """Do tasks until the other end closes: the body of a worker process."""
    # Ctrl-C reaches the whole group; the parent alone decides what happens then. POSIX workers
    # are deaf already, see `_interrupts_held`.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with closing(connection):
        while True:
            try:
                task = connection.recv()
            except EOFError:
                return
            connection.send(work(task))
