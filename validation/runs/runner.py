"""Run tasks, store each result when it is complete, and reuse stored results.

Each task has a key: a hash of everything that its result depends on besides the code. `run` reuses
stored results with the same key, runs the other tasks in processes or on a cluster, and stores each
result when the task ends.
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
    """A run that can't start: no tasks, a repeated task, no process, or a bad time limit."""


def check_limits(jobs: int, time_limit: float | None) -> None:
    """Refuse a number of processes below 1, or a time limit [s] that isn't positive and finite."""
    if jobs < 1:
        raise RunError(f"`jobs` must be at least 1, got {jobs}")
    if time_limit is not None and not 0.0 < time_limit < math.inf:
        raise RunError(f"`time_limit` must be a positive number of seconds, got {time_limit!r}")


def check_each_once(what: str, names: Sequence[str]) -> None:
    """Refuse a run without scenes or engines, or with one given twice."""
    if not names:
        raise RunError(f"a run needs at least one {what}, got none")
    repeated = sorted({name for name in names if names.count(name) > 1})
    if repeated:
        raise RunError(f"each {what} must be given once, got {', '.join(repeated)} more than once")


@dataclass(frozen=True, eq=False)
class Reuse(Generic[R]):
    """Results of earlier runs that are reused.

    `records`: in the order of the run.
    `stored`: number of stored records that could have been reused.
    `why`: why none is reused, if one reason applies to all; else "".
    """

    records: Mapping[Name, R] = field(default_factory=dict)
    stored: int = 0
    why: str = ""


@dataclass(frozen=True, eq=False)
class Ran(Generic[R]):
    """Result of a run.

    `records`: reused records, then the other records in order of completion.
    `interrupted`: whether Ctrl-C ended the run; the store holds the finished records.
    `begun`: whether the records of this run, possibly none, replaced earlier ones.
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
    """Run the tasks without a stored result, and store each result when it is complete.

    `keys`: for each task, in the order of the run, the hash of everything that its result depends
        on besides the code; "" if the task must always run.
    `tasks`: yields the tasks of these names; each is requested when a process is free.
    `work`: runs a task; a function of a module.
    `conclude`: returns what is stored for a finished task, or for one that crashed.
    `jobs`, `limit`, `kind`: see `run_tasks`.
    `prepare`: called with the names of the tasks that will run, does the work they need, such as
        compiling; each process first calls the function that it returns.
    `about`: called with the reused records, returns the description of the run for the store, as
        plain values.
    `reuse`, `announce`, `progress`: see `suite.run_suite`, with records in place of cases.

    Earlier records are replaced when the first task of this run is complete. Ctrl-C ends the run,
    and the returned value says so; a later run continues from there.
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
            pass  # the returned value says so
        finally:
            store.finish(state)
    has_begun = store.begun
    if state == "interrupted":
        # The store decides, because Ctrl-C may have come between writing a record and adding it to
        # `records`.
        current = store.current() if has_begun else {}
        records = {name: record for name, record in current.items() if name in keys}
    return Ran(records, len(reused.records), state == "interrupted", has_begun)


def _reuse(keys: Mapping[Name, str], store: RecordStore[W, R]) -> Reuse[R]:
    stored, same = store.known()
    records = {name: same[key] for name, key in keys.items() if key in same}
    why = "the code or the environment changed" if stored and not same else ""
    return Reuse(records, stored, why)
