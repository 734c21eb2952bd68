"""The one runner: tasks that have a key are done, stored as they end, and not done again.

The cases of the suite are tasks with a key, which is all that their result
depends on besides the code: `run` reuses what a store knows by that key, does the others in
processes or on a cluster, and stores each as it ends.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from ghostball.model import GhostballError
from ghostball.validation.parallel.pool import Done, Progress, Workers, one_kind, run_tasks
from ghostball.validation.results.record_store import Name, RecordStore, RunState

T = TypeVar("T")
G = TypeVar("G")
W = TypeVar("W")
R = TypeVar("R")


class RunError(GhostballError, ValueError):
    """A run that can't start: of nothing, of one thing twice, in no process, or with no limit."""


def check_limits(jobs: int, time_limit: float | None) -> None:
    """Refuse a number of processes, or a limit of time [s], that is none."""
    if jobs < 1:
        raise RunError(f"`jobs` must be at least 1, got {jobs}")
    if time_limit is not None and not 0.0 < time_limit < math.inf:
        raise RunError(f"`time_limit` must be a positive number of seconds, got {time_limit!r}")


def check_each_once(what: str, names: Sequence[str]) -> None:
    """Refuse a run of no scene or no engine, or of one twice."""
    if not names:
        raise RunError(f"a run needs at least one {what}, got none")
    repeated = sorted({name for name in names if names.count(name) > 1})
    if repeated:
        raise RunError(f"each {what} must be given once, got {', '.join(repeated)} more than once")


@dataclass(frozen=True, eq=False)
class Reuse(Generic[R]):
    """What is reused of earlier runs.

    `records`: in the order of the run.
    `stored`: how many records there are that could have been reused.
    `why`: why none is, where the reason is one for all; else "".
    """

    records: Mapping[Name, R] = field(default_factory=dict)
    stored: int = 0
    why: str = ""


@dataclass(frozen=True, eq=False)
class Ran(Generic[R]):
    """What a run came to.

    `records`: those reused, then the others as they ended.
    `interrupted`: whether it was cut short by Ctrl-C; the store has what was done.
    `begun`: whether earlier records gave way to those of this run, be they none.
    """

    records: Mapping[Name, R]
    reused: int
    interrupted: bool
    begun: bool


def run(
    keys: Mapping[Name, str],
    tasks: Callable[[Sequence[Name]], Iterable[T]],
    work: Callable[[T], G],
    conclude: Callable[[Done[T, G]], W],
    store: RecordStore[W, R],
    *,
    jobs: int | Workers = 1,
    limit: Callable[[T], float] | float | None = None,
    prepare: Callable[[Sequence[Name]], Callable[[], object] | None] | None = None,
    kind: Callable[[T], str] = one_kind,
    about: Callable[[Mapping[Name, R]], Mapping[str, Any]] | None = None,
    reuse: bool = True,
    announce: Callable[[Reuse[R]], None] | None = None,
    progress: Progress[R] | None = None,
) -> Ran[R]:
    """Do what isn't known yet, and store each as it ends.

    `keys`: hash of all that each task's result depends on besides the code, in the order of the
        run; "" where it is done whatever is known.
    `tasks`: yields the tasks of these names; each is asked for when there is a process for it.
    `work`: does a task; a function of a module.
    `conclude`: returns what is stored of what came of a task, also where its process crashed.
    `jobs`, `limit`, `kind`: see `run_tasks`.
    `prepare`: given the names of what isn't known, does what is needed before, such as compiling;
        what it returns, each process does first.
    `about`: given what is reused, returns what the store says of the whole run, as plain values.
    `reuse`, `announce`, `progress`: see `suite.run_suite`: of records in place of cases.

    Earlier records give way when the first of this run is done. Ctrl-C ends it, and is said in what
    is returned; a next run continues from there.
    """
    with store.reserved():
        reused = _reuse(keys, store) if reuse else Reuse[R]()
        if announce is not None:
            announce(reused)
        records = dict(reused.records)
        state: RunState = "interrupted"
        begun = False

        def begin() -> None:
            store.begin({} if about is None else about(reused.records), reused.records)

        try:
            rest = [name for name in keys if name not in records]
            first = prepare(rest) if rest and prepare is not None else None
            with closing(run_tasks(tasks(rest), jobs, work, limit, first, kind)) as finished:
                for done in finished:
                    if not begun:
                        begin()
                        begun = True
                    given = conclude(done)
                    name = store.name_of(store.record_of(given))
                    records[name] = store.write(given, keys[name])
                    if progress is not None:
                        progress(len(records), len(keys), records[name])
            if not begun:
                begin()
            state = "complete"
        except KeyboardInterrupt:
            pass  # said in what is returned
        finally:
            store.finish(state)
    has_begun = store.begun
    if state == "interrupted":
        # What the store says: the interrupt may have come between a record and its being noted.
        current = store.current() if has_begun else {}
        records = {name: record for name, record in current.items() if name in keys}
    return Ran(records, len(reused.records), state == "interrupted", has_begun)


def _reuse(keys: Mapping[Name, str], store: RecordStore[W, R]) -> Reuse[R]:
    stored, same = store.known()
    records = {name: same[key] for name, key in keys.items() if key in same}
    why = "the code or the environment changed" if stored and not same else ""
    return Reuse(records, stored, why)
