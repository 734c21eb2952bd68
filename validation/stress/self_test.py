"""The harness proves itself: bugs planted in our engine, and which the stress suite catches.

>>> outcome = self_test(jobs=2)
>>> outcome.exit_status
0

Each bug is planted in a copy of our engine of its own, and the small trials of the quick suite run
there, in a process of their own with interpreted kernels, until one breaks: it has killed the
mutant. So does a trial that ends the process, or hangs. A copy without a bug must survive them all.
"""

from __future__ import annotations

import json
import queue
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import IO, Any

from validation.leash import end_group
from validation.mutants import START_LIMIT, Mutant, MutantError, Mutation, planted
from validation.stress.mutations import MUTATIONS
from validation.stress.probe import PROCESSOR_LIMIT, small_trials
from validation.stress.run import CHECK_FAILED, INTERRUPTED, PASSED
from validation.stress.trial import StressError

TIME_LIMIT = 30.0
"""How long a mutant may be silent in a trial [s]."""

UNCHANGED = "unchanged"
"""Name of the copy without a bug."""

_POLL = 0.2
"""Seconds between looks at the clock."""


@dataclass(frozen=True)
class Found:
    """What became of one copy.

    Attributes
    ----------
    name, what : str
        Of its bug; see `Mutation`.
    killed_by : str
        The first trial that broke, as FAMILY/TRIAL; "" where all held.
    faults : tuple of str
        What broke there.
    tried : int
        Trials, with the one that broke.
    seconds : float
        Wall time.
    """

    name: str
    what: str
    killed_by: str
    faults: tuple[str, ...]
    tried: int
    seconds: float

    @property
    def killed(self) -> bool:
        """Whether a trial broke."""
        return bool(self.killed_by)


@dataclass(frozen=True)
class SelfTest:
    """What a self-test came to.

    Attributes
    ----------
    planned : int
        Mutants that there are.
    trials : int
        Small trials of the suite.
    mutants : tuple of Found
        Those that were tried, in the order of `MUTATIONS`.
    unchanged : Found or None
        The copy without a bug; None where it wasn't come to.
    interrupted : bool
        By Ctrl-C.
    """

    planned: int
    trials: int
    mutants: tuple[Found, ...]
    unchanged: Found | None
    interrupted: bool = False

    @property
    def survivors(self) -> tuple[Found, ...]:
        """The mutants that no trial broke on."""
        return tuple(one for one in self.mutants if not one.killed)

    @property
    def exit_status(self) -> int:
        """0 all mutants were killed and the unchanged copy survived; 1 not; 130 interrupted."""
        if self.interrupted:
            return INTERRUPTED
        clean = self.unchanged is not None and not self.unchanged.killed
        all_killed = len(self.mutants) == self.planned and not self.survivors
        return PASSED if clean and all_killed else CHECK_FAILED


Progress = Callable[[Found, int, int], None]
"""Called with each copy that is done, how many there are, and how many there will be."""


def self_test(
    *,
    jobs: int = 1,
    only: Sequence[str] = (),
    mutations: Sequence[Mutation] = MUTATIONS,
    progress: Progress | None = None,
    time_limit: float = TIME_LIMIT,
) -> SelfTest:
    """Plant bugs, one at a time, and see which the suite catches.

    Parameters
    ----------
    jobs : int
        Copies that run at once.
    only : sequence of str
        Families, or trials as `FAMILY/TRIAL`, also as patterns; all where it is empty.
    mutations : sequence of Mutation
        The bugs.
    progress : callable, optional
        See `Progress`.
    time_limit : float [s]
        How long a trial may take; the start of a copy doesn't count.

    Raises
    ------
    StressError
        Where nothing is called as one of `only`.
    MutantError
        Where a mutation doesn't fit the engine, or breaks it so that it can't be imported.
    """
    if jobs < 1:
        raise StressError(f"`jobs` must be at least 1, got {jobs}")
    for pattern in only or ("*",):
        if not small_trials([pattern]):
            raise StressError(f"no family or small trial of the quick suite is called {pattern!r}")
    found: dict[str, Found] = {}
    interrupted = False
    # The unchanged copy first: it takes longest, since it runs everything.
    waiting: list[Mutation | None] = [None, *mutations]
    with _Watch(only, time_limit) as watch:
        try:
            while waiting or watch.running:
                while waiting and len(watch.running) < jobs:
                    watch.start(waiting.pop(0))
                for one in watch.ended():
                    found[one.name] = one
                    if progress is not None:
                        progress(one, len(found), 1 + len(mutations))
        except KeyboardInterrupt:
            interrupted = True
    mutants = tuple(found[one.name] for one in mutations if one.name in found)
    trials = len(small_trials(only))
    return SelfTest(len(mutations), trials, mutants, found.get(UNCHANGED), interrupted)


@dataclass(eq=False)
class _Running:
    """A copy at work, and what it has said so far."""

    mutant: Mutant
    what: str
    process: subprocess.Popen[str]
    messages: IO[str]
    place: ExitStack
    listener: threading.Thread
    begun: float
    deadline: float
    trying: str = ""
    tried: int = 0
    faults: tuple[str, ...] = field(default=())

    def found(self, killed_by: str, faults: tuple[str, ...]) -> Found:
        seconds = time.monotonic() - self.begun
        return Found(self.mutant.name, self.what, killed_by, faults, self.tried, seconds)


class _Watch:
    """Processes of copies: started, listened to, and ended with the block."""

    def __init__(self, only: Sequence[str], time_limit: float) -> None:
        self.running: list[_Running] = []
        self._only = list(only)
        self._limit = time_limit
        self._said: queue.SimpleQueue[tuple[subprocess.Popen[str], str]] = queue.SimpleQueue()

    def __enter__(self) -> _Watch:
        return self

    def __exit__(self, *_: object) -> None:
        for one in list(self.running):
            self._end(one)

    def start(self, mutation: Mutation | None) -> None:
        """Plant a bug, or none, and let the copy run."""
        with ExitStack() as place:
            mutant = place.enter_context(planted(*filter(None, [mutation])))
            messages = place.enter_context(tempfile.TemporaryFile(mode="w+", encoding="utf-8"))
            command = [sys.executable, "-m", "validation.stress.probe", str(mutant.folder)]
            process = subprocess.Popen(
                [*command, *self._only],
                cwd=mutant.folder,
                env=mutant.environment,
                stdin=subprocess.PIPE,  # it ends when this closes, and so with this process
                stdout=subprocess.PIPE,
                stderr=messages,
                text=True,
                start_new_session=True,  # Ctrl-C is for this process alone, which ends the others
            )
            listener = threading.Thread(target=self._listen, args=(process,), daemon=True)
            now = time.monotonic()
            what = mutation.what if mutation is not None else ""
            self.running.append(
                _Running(
                    mutant,
                    what,
                    process,
                    messages,
                    place.pop_all(),
                    listener,
                    now,
                    now + START_LIMIT,
                )
            )
        listener.start()

    def _listen(self, process: subprocess.Popen[str]) -> None:
        assert process.stdout is not None
        for line in process.stdout:
            self._said.put((process, line))
        self._said.put((process, ""))

    def ended(self) -> list[Found]:
        """Wait for a moment, or for a line; return what became of the copies that are done."""
        done = []
        try:
            process, line = self._said.get(timeout=_POLL)
        except queue.Empty:
            pass
        else:
            one = next((one for one in self.running if one.process is process), None)
            if one is not None and (found := self._heard(one, line)) is not None:
                done.append(found)
        for one in list(self.running):
            if time.monotonic() >= one.deadline:
                limit = self._limit if one.tried else START_LIMIT
                done.append(self._given_up(one, f"no answer in {limit:g} s"))
        return done

    def _heard(self, one: _Running, line: str) -> Found | None:
        """Take note of a line, "" being the end; return what became of the copy if it is done."""
        if not line:
            code = one.process.wait()
            if code == 0 and not one.trying:
                self._end(one)
                return one.found("", ())
            if _ran_out_of_time(code):
                reason = f"no end in {PROCESSOR_LIMIT:g} s of processor time"
            else:
                reason = f"exit code {code}: {_last_line(one.messages)}"
            return self._given_up(one, reason)
        one.deadline = time.monotonic() + self._limit
        said: dict[str, Any] = json.loads(line)
        if "tries" in said:
            one.trying = said["tries"]
            one.tried += 1
            return None
        one.trying = ""
        # Nothing but the bug makes the harness fail where it doesn't in the copy without one.
        if said["outcome"] not in ("broken", "failed"):
            return None
        self._end(one)
        return one.found(said["tried"], tuple(said["faults"]))

    def _given_up(self, one: _Running, reason: str) -> Found:
        """End a copy that died or hung: the trial that it was at has killed it."""
        trying = one.trying
        self._end(one)
        if not one.tried:
            raise MutantError(
                f'mutant "{one.mutant.name}" can\'t be imported: {reason}. Mend the mutation: it '
                "should play shots wrongly, not break a module"
            )
        return one.found(trying or "after the last trial", (reason,))

    def _end(self, one: _Running) -> None:
        self.running.remove(one)
        end_group(one.process)  # with what a trial started
        one.listener.join()
        for stream in (one.process.stdin, one.process.stdout):
            if stream is not None:
                stream.close()
        one.place.close()


def _ran_out_of_time(code: int) -> bool:
    return hasattr(signal, "SIGPROF") and code == -signal.SIGPROF


def _last_line(messages: IO[str]) -> str:
    messages.seek(0)
    return (messages.read().strip().splitlines() or ["no message"])[-1]
