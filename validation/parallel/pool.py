"""Work in several processes: a crash costs one task, an interrupt leaves no process behind.

A task that hangs costs no more than itself either, if it has a limit of time. A process has one
pipe of its own, so that one that crashes in the midst of its answer spoils no other's. It leads a
process group, which also holds what its tasks start; the group ends with the process.

Nothing of what the tasks do is imported here: a process imports what its own tasks need.
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
from ghostball.validation.parallel.group import FAILED, end_with_parent, interrupts_held

S = TypeVar("S")
T = TypeVar("T")
R = TypeVar("R")

START_LIMIT = 300.0
"""Seconds that a process gets to start and import, where tasks have a limit of time."""

WAKE = 1.0
"""Seconds that we wait at a time.

Ctrl-C that comes between Python's last look for it and the wait, or that another thread is given,
is seen only when the wait ends.
"""

_JOIN_TIMEOUT = 5.0
"""Seconds that a process whose pipe has ended gets until its exit code is known."""

_SPAWN = multiprocessing.get_context("spawn")
"""Not fork: pybullet's threads and locks don't survive it."""


@dataclass(frozen=True)
class Done(Generic[T, R]):
    """What came of a task.

    `given`: what it gave; None where its process crashed.
    `crashed`: why its process crashed, or was ended; else "".
    `printed`: what was printed while it was done.
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
        """Return what it gave, or what `crashed` makes of it and of why it crashed."""
        if self.crashed:
            return crashed(self.task, self.crashed)
        given: Any = self.given  # None too may be what it gave
        return given  # type: ignore[no-any-return]


def one_kind(_: object) -> str:
    """Return the same kind for every task, so that all tasks may share processes."""
    return ""


class Workers(Protocol):
    """Processes of other machines, such as those of a cluster."""

    def run_tasks(
        self,
        tasks: Iterable[T],
        work: Callable[[T], R],
        limit: Callable[[T], float] | None = None,
        prepare: Callable[[], object] | None = None,
        kind: Callable[[T], str] = one_kind,
    ) -> Generator[Done[T, R]]:
        """Do tasks there; see `run_tasks` of this module."""


Progress = Callable[[int, int, R], None]
"""Called with how many parts are done, how many there are, and the last of them."""


def limit_of(limit: Callable[[T], float] | float | None) -> Callable[[T], float] | None:
    """Return how long a task may take [s], of a `limit` of `run_tasks`; None for none.

    The one place that decides whether tasks need processes of their own: tests that plant engines
    replace it.
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
    """Do tasks in other processes; yield what came of each.

    In this very process where `jobs` is 1 and there is no limit. Nothing that a task prints reaches
    our own standard output or, from another process, standard error.

    `tasks`: taken one by one, as processes become free.
    `jobs`: processes of this machine, or a cluster, which does as many tasks at once as it can.
    `work`: does a task; a function of a module, for other processes must find it.
    `limit` [s]: how long a task may take, or what says it of each: after that its process is ended,
        and it counts as crashed. The start of a process doesn't count; that has a limit of its own,
        of minutes.
    `prepare`: what another process does first, such as importing what tasks need: no task's limit
        of time runs meanwhile.
    `kind`: returns the kind of a task. A process does tasks of one kind only, so that no task can
        change what a task of another kind finds. "" is the kind of this project's own engines;
        another one is the name of another project's engine (`sources.code_kind`). There are at
        most as many processes as jobs times kinds, of which at most `jobs` work.

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
    """Another process, which does one task after another until it is closed, or crashes.

    It leads a process group. What its tasks start and leave behind ends with it, except for a
    process that makes a session of its own; on Windows, which has no groups, it alone ends.

    `first`: what does its tasks, and what it does before; pickled, as all that it is given.
    `start_limit` [s]: how long it may take to start, where the first task has a limit of time.
    """

    _limit: float | None

    def __init__(self, first: bytes, start_limit: float) -> None:
        self._start_limit = start_limit
        file, self._path = tempfile.mkstemp(prefix="ghostball-")
        self._output = os.fdopen(file, "r+b", buffering=0)
        self._pipe, theirs = _SPAWN.Pipe()
        # A daemon is ended where this process exits, which else would wait for it.
        self._process = _SPAWN.Process(target=_serve, args=(theirs, self._path, first), daemon=True)
        with interrupts_held():
            self._process.start()
        theirs.close()
        self._pickled, self._limit, self._is_ready = b"", start_limit, False
        self._is_late = False
        self._since = time.monotonic()

    @property
    def is_alive(self) -> bool:
        """Whether it can be given a task."""
        return self._process.is_alive()

    @property
    def signs(self) -> tuple[Any, ...]:
        """What `multiprocessing.connection.wait` waits for, until there is something to answer."""
        return self._pipe, self._process.sentinel

    def give(self, pickled: bytes, limit: float | None) -> None:
        """Let it do a task, within so many seconds; the one before must have been answered."""
        os.ftruncate(self._output.fileno(), 0)  # of the task before
        self._pickled, self._limit = pickled, limit
        if self._is_ready:
            self._send()

    def answer(self) -> Done[None, bytes] | None:
        """Return what came of the task, given pickled; None while it is being done."""
        is_alive = self._process.is_alive()  # what it answers before it crashes is there afterwards
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
        """Seconds until it is out of time, be it with its start or with its task."""
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
        """End it, whatever it does: it is gone then, with all that was made for it."""
        self.kill()
        self._process.join()
        if hasattr(os, "killpg"):
            assert self._process.pid is not None
            # As the first process of a container we inherit processes whose parent has ended.
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
        with suppress(OSError):  # where it is dead, its answer says so
            self._pipe.send_bytes(self._pickled)
        self._since = time.monotonic()


def wait(processes: Iterable[Process]) -> None:
    """Wait until one of them may have answered, but not for long: see `WAKE`."""
    processes = tuple(processes)
    signs = [sign for process in processes for sign in process.signs]
    wait_for_any(signs, max(0.0, min([WAKE, *(process.left for process in processes)])))


def _serve(pipe: Connection, output: str, pickled: bytes) -> None:
    """Do tasks, in a process of its own: say that it is ready, then answer one after another."""
    divert(output)
    faulthandler.enable(all_threads=False)  # a crash then says where, into what is printed
    end_with_parent()
    process = os.getpid()
    _, prepare = pickle.loads(pickled)  # and import what the work needs
    if prepare is not None:
        prepare()
    end_if_forked(process)
    pipe.send_bytes(b"")
    while True:
        pipe.send_bytes(_do(pipe.recv_bytes()))


def _do(pickled: bytes) -> bytes:
    """Do a task, and return what it gives, pickled."""
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
