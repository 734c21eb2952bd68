"""Run tasks in several processes: a crash loses one task, an interrupt leaves no process behind.

With a time limit, a task that hangs also loses only itself. Each process has its own pipe, so a
process that crashes while it sends an answer can't damage another answer. Each process leads a
process group with the processes that its tasks start; the group ends with the process.

This module imports nothing that tasks need: a process imports what its own tasks need.
"""

from __future__ import annotations

import faulthandler
import math
import multiprocessing
import os
import pickle
import signal
import tempfile
import threading
import time
import traceback
from collections.abc import Callable, Generator, Iterable
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
from multiprocessing.connection import Connection, wait as wait_for_any
from typing import Any, Generic, Protocol, TypeVar

from ghostball.reference_adapters.output import captured, divert, end_if_forked, flush, text_of
from ghostball.validation.parallel.process_group import FAILED, end_with_parent, interrupts_held

S = TypeVar("S")
T = TypeVar("T")
R = TypeVar("R")

START_LIMIT = 300.0
"""Time limit [s] for the start of a process and its imports, if tasks have a time limit."""

LONGEST_WAIT = 1.0
"""Longest single wait [s].

A Ctrl-C that arrives between Python's last check and the wait, or in another thread, takes effect
only when the wait ends.
"""

_JOIN_TIMEOUT = 5.0
"""Time limit [s] for the exit code of a process after its pipe has closed."""

_SPAWN = multiprocessing.get_context("spawn")
"""Not fork: the threads and locks of pybullet don't survive it."""


@dataclass(frozen=True)
class Done(Generic[T, R]):
    """Result of a task.

    `given`: the returned value; None if its process crashed.
    `crashed`: why its process crashed, or was ended; else "".
    `printed`: the output of the task.
    """

    task: T
    given: R | None
    crashed: str
    printed: str

    def of(self, task: S) -> Done[S, Any]:
        """Return the result of a task from the pickled answer of its process.

        An unreadable answer counts as a crash: other code in this process wrote to the pipe.
        """
        if self.given is None:
            return Done(task, None, self.crashed, self.printed)
        try:
            given = pickle.loads(self.given)  # type: ignore[arg-type]
        except Exception as error:
            why = (
                f"its process returned an answer that can't be read ({type(error).__name__}: "
                f"{error})"
            )
            return Done(task, None, why, self.printed)
        return Done(task, given, self.crashed, self.printed)

    def or_else(self, crashed: Callable[[T, str], R]) -> R:
        """Return the result; after a crash, the value of `crashed` for the task and the reason."""
        if self.crashed:
            return crashed(self.task, self.crashed)
        given: Any = self.given  # None may also be the result
        return given  # type: ignore[no-any-return]


def one_kind(_: object) -> str:
    """Return the same kind for every task, so that all tasks may share processes."""
    return ""


class Workers(Protocol):
    """Processes on other machines, such as those of a cluster."""

    def run_tasks(
        self,
        tasks: Iterable[T],
        work: Callable[[T], R],
        limit: Callable[[T], float] | None = None,
        prepare: Callable[[], object] | None = None,
        kind: Callable[[T], str] = one_kind,
    ) -> Generator[Done[T, R]]:
        """Run tasks there; see `run_tasks` of this module."""


Progress = Callable[[int, int, R], None]
"""Called with the number of finished parts, the number of all parts, and the last finished part."""


def limit_of(limit: Callable[[T], float] | float | None) -> Callable[[T], float] | None:
    """Return a function that gives the time limit of a task [s], from the `limit` of `run_tasks`.

    None: no limit. Only this function decides whether tasks need separate processes, so tests with
    artificial engines replace it.
    """
    if limit is None or callable(limit):
        return limit
    seconds = limit
    return lambda _: seconds


def run_tasks(
    tasks: Iterable[T],
    jobs: int | Workers,
    work: Callable[[T], R],
    limit: Callable[[T], float] | float | None = None,
    prepare: Callable[[], object] | None = None,
    kind: Callable[[T], str] = one_kind,
) -> Generator[Done[T, R]]:
    """Run tasks in other processes; yield the result of each.

    With `jobs` equal to 1 and no limit, tasks run in this process. Output of a task doesn't reach
    the standard output of this process or, from another process, its standard error.

    `tasks`: requested one by one, as processes become free.
    `jobs`: number of processes on this machine, or a cluster, which runs as many tasks at once as
        it can.
    `work`: runs a task; a function of a module, so that other processes can import it.
    `limit` [s]: time limit of a task, or a function that returns the limit of each; after that time
        its process is ended, and the task counts as crashed. The start of a process doesn't count;
        it has a separate limit of minutes.
    `prepare`: called first in each process, for example to import what tasks need; it doesn't count
        for the time limit.
    `kind`: returns the kind of a task. A process runs tasks of one kind only, so a task can't
        affect tasks of another kind. "" is the kind of this project's own engines; other kinds are
        names of engines of other projects (`sources.code_kind`). There are at most `jobs` times as
        many processes as kinds, of which at most `jobs` run at once.

    Close the generator to stop early: its processes are gone when `close` returns.
    """
    limit = limit_of(limit)
    if not isinstance(jobs, int):
        yield from jobs.run_tasks(tasks, work, limit, prepare, kind)
        return
    if jobs == 1 and limit is None:
        for task in tasks:
            with captured() as output:
                given = work(task)
            yield Done(task, given, "", output.text)
        return
    first = pickle.dumps((work, prepare))
    queue = iter(tasks)
    processes: dict[Process, str] = {}
    doing: dict[Process, T] = {}

    def free(wanted: str) -> Process:
        for process in [one for one in processes if one not in doing]:
            if not process.is_alive:
                # The process crashed after its last task, because of something that this task left
                # behind: the next task isn't to blame.
                process.close()
                del processes[process]
            elif processes[process] == wanted:
                return process
        started = Process(first, START_LIMIT)
        processes[started] = wanted
        return started

    try:
        while True:
            for task in islice(queue, jobs - len(doing)):
                process = free(kind(task))
                process.give(pickle.dumps((work, task)), None if limit is None else limit(task))
                doing[process] = task
            if not doing:
                return
            wait(doing)
            for process, task in tuple(doing.items()):
                answer = process.answer()
                if answer is None:
                    continue
                done = answer.of(task)
                if done.crashed:
                    process.close()
                    del processes[process]
                del doing[process]
                yield done
    finally:
        for process in processes:
            process.kill()
        for process in processes:
            process.close()


class Process:
    """A process that runs one task after another until it is closed, or crashes.

    It leads a process group. Processes that its tasks leave behind end with it, except for a
    process with its own session. On Windows, which has no process groups, only the process itself
    ends.

    `first`: function that runs its tasks, and function that prepares it, pickled.
    `start_limit` [s]: time limit for the start, if the first task has a time limit.
    """

    _limit: float | None

    def __init__(self, first: bytes, start_limit: float) -> None:
        self._start_limit = start_limit
        file, self._path = tempfile.mkstemp(prefix="ghostball-")
        self._output = os.fdopen(file, "r+b", buffering=0)
        self._pipe, theirs = _SPAWN.Pipe()
        # A daemon is ended when this process exits; otherwise this process would wait for it.
        self._process = _SPAWN.Process(target=_serve, args=(theirs, self._path, first), daemon=True)
        with interrupts_held():
            self._process.start()
        theirs.close()
        self._pickled, self._limit, self._is_ready = b"", start_limit, False
        self._is_late = False
        self._since = time.monotonic()

    @property
    def is_alive(self) -> bool:
        """Whether it can receive a task."""
        return self._process.is_alive()

    @property
    def signs(self) -> tuple[Any, ...]:
        """Objects for `multiprocessing.connection.wait`, ready when there may be an answer."""
        return self._pipe, self._process.sentinel

    def give(self, pickled: bytes, limit: float | None) -> None:
        """Start a task with a time limit [s]; the task before must have been answered."""
        os.ftruncate(self._output.fileno(), 0)  # remove the output of the task before
        self._pickled, self._limit = pickled, limit
        if self._is_ready:
            self._send()

    def answer(self) -> Done[None, bytes] | None:
        """Return the answer of the task, with a pickled result; None while the task is running."""
        # checked first: an answer sent before a crash is still in the pipe
        is_alive = self._process.is_alive()
        try:
            if not self._is_ready and self._pipe.poll():
                self._pipe.recv_bytes()
                self._is_ready = True
                self._send()
            if self._is_ready and self._pipe.poll():
                return Done(None, self._received(), "", text_of(self._output))
        except (EOFError, OSError):
            is_alive = False
        if not is_alive and self._is_late:
            reason = f"it exceeded the time limit of {self._limit:g} s while it returned its answer"
        elif not is_alive:
            self._process.join(_JOIN_TIMEOUT)
            reason = f"its process crashed (exit code {self._process.exitcode})"
        elif self.left > 0.0:
            return None
        elif self._is_ready:
            reason = f"it exceeded the time limit of {self._limit:g} s"
        else:
            reason = f"its process did not start within {self._start_limit:g} s"
        return Done(None, None, reason, text_of(self._output))

    @property
    def left(self) -> float:
        """Time [s] until the limit of its start or its task is reached."""
        if self._limit is None:
            return math.inf
        limit = self._limit if self._is_ready else self._start_limit
        return limit - (time.monotonic() - self._since)

    def kill(self) -> None:
        """Kill the process and its group at once, without waiting for their end."""
        if hasattr(os, "killpg"):
            assert self._process.pid is not None
            with suppress(ProcessLookupError, PermissionError):  # no group yet; macOS: all ended
                os.killpg(self._process.pid, signal.SIGKILL)
        self._process.kill()

    def close(self) -> None:
        """End the process, even during a task, and remove everything that belongs to it."""
        self.kill()
        self._process.join()
        if hasattr(os, "killpg"):
            assert self._process.pid is not None
            # In a container, this process may be the parent of processes that lost theirs.
            with suppress(ChildProcessError):
                while True:
                    os.waitpid(-self._process.pid, 0)
        self._process.close()
        self._pipe.close()
        self._output.close()
        with suppress(OSError):
            os.unlink(self._path)

    def _received(self) -> bytes:
        """Return an answer; end the process if the rest of the answer doesn't come in time."""
        if math.isinf(self.left):
            return self._pipe.recv_bytes()

        def give_up() -> None:
            self._is_late = True
            self.kill()

        watch = threading.Timer(self.left, give_up)
        watch.daemon = True
        watch.start()
        try:
            return self._pipe.recv_bytes()
        finally:
            watch.cancel()

    def _send(self) -> None:
        with suppress(OSError):  # if the process is dead, its answer reports this
            self._pipe.send_bytes(self._pickled)
        self._since = time.monotonic()


def wait(processes: Iterable[Process]) -> None:
    """Wait until one of the processes may have an answer, but at most `LONGEST_WAIT` seconds."""
    processes = tuple(processes)
    signs = [sign for process in processes for sign in process.signs]
    wait_for_any(signs, max(0.0, min([LONGEST_WAIT, *(process.left for process in processes)])))


def _serve(pipe: Connection, output: str, pickled: bytes) -> None:
    """Run tasks in this process: report that it is ready, then run one task after another."""
    divert(output)
    faulthandler.enable(all_threads=False)  # a crash then writes a traceback into the output
    end_with_parent()
    process = os.getpid()
    _, prepare = pickle.loads(pickled)  # also imports what the work needs
    if prepare is not None:
        prepare()
    end_if_forked(process)
    pipe.send_bytes(b"")
    while True:
        pipe.send_bytes(_do(pipe.recv_bytes()))


def _do(pickled: bytes) -> bytes:
    """Run a task, and return its pickled result."""
    process = os.getpid()
    try:
        work, task = pickle.loads(pickled)
        given = pickle.dumps(work(task))
        end_if_forked(process)
    except BaseException:
        end_if_forked(process)
        traceback.print_exc()
        flush()
        os._exit(FAILED)
    flush()
    return given
