"""Cases in several processes: a crash costs one case, an interrupt leaves no process behind."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Generator, Iterable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess

from validation.case import Case, blank_record, failed, run_case
from validation.records import CaseRecord, Motion

Finished = tuple[CaseRecord, Motion | None]

_JOIN_TIMEOUT = 5.0
"""Seconds that a terminated worker gets before it is killed."""

# Not fork: pybullet's and numba's threads and locks don't survive it.
_CONTEXT = multiprocessing.get_context("spawn")


@dataclass(eq=False)
class _Worker:
    process: SpawnProcess
    connection: Connection
    case: Case | None = None


def run_cases(cases: Iterable[Case], jobs: int) -> Generator[Finished]:
    """Run cases in `jobs` processes, or in this one where it is 1; yield each as it ends.

    Parameters
    ----------
    cases : iterable of Case
        Taken one by one, as processes become free.
    jobs : int

    Notes
    -----
    Close the generator to stop early: its processes are gone when `close` returns.
    """
    if jobs == 1:
        yield from map(run_case, cases)
        return
    queue = iter(cases)
    workers: list[_Worker] = []
    try:
        while True:
            _hand_out(queue, workers, jobs)
            busy = [worker for worker in workers if worker.case is not None]
            if not busy:
                return
            ready = wait([worker.connection for worker in busy])
            for worker in busy:
                if worker.connection in ready:
                    yield _collect(worker, workers)
    finally:
        for worker in workers:
            worker.process.terminate()
        for worker in workers:
            _bury(worker)


def _hand_out(queue: Iterator[Case], workers: list[_Worker], jobs: int) -> None:
    """Give every idle process a case, starting processes up to `jobs`."""
    while True:
        idle = next((worker for worker in workers if worker.case is None), None)
        if idle is None and len(workers) == jobs:
            return
        case = next(queue, None)
        if case is None:
            return
        if idle is None:
            idle = _start()
            workers.append(idle)
        idle.case = case
        with suppress(BrokenPipeError):  # it died while idle: `_collect` reports the case
            idle.connection.send(case)


def _collect(worker: _Worker, workers: list[_Worker]) -> Finished:
    """Take a finished case from its process, or note that the process died of it."""
    case = worker.case
    assert case is not None
    try:
        finished: Finished = worker.connection.recv()
    except (EOFError, ConnectionResetError):
        workers.remove(worker)
        _bury(worker)
        code = worker.process.exitcode
        return failed(blank_record(case), f"the process running it died (exit code {code})"), None
    worker.case = None
    return finished


def _start() -> _Worker:
    ours, theirs = _CONTEXT.Pipe()
    process = _CONTEXT.Process(target=_serve, args=(theirs,), daemon=True)
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


def _bury(worker: _Worker) -> None:
    worker.process.join(_JOIN_TIMEOUT)
    if worker.process.is_alive():
        worker.process.kill()
        worker.process.join()
    worker.connection.close()


def _serve(connection: Connection) -> None:
    """Run cases until the other end closes: the body of a worker process."""
    # Ctrl-C reaches the whole group; the parent alone decides what happens then. POSIX workers
    # are deaf already, see `_interrupts_held`.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with closing(connection):
        while True:
            try:
                case = connection.recv()
            except EOFError:
                return
            connection.send(run_case(case))
