"""Stored measurements over time: every committed version of the files in benchmarks/results."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path

from pydantic import ValidationError

from ghostball.validation.bench import measurements
from ghostball.validation.bench._observed import KINDS, Observed, observed_in
from ghostball.validation.bench.running import BenchError
from ghostball.validation.results.files import told
from ghostball.validation.results.git import GitError, run_git

PLACE = "benchmarks/results"
"""Where measurements lie in the repository, as git names folders."""

_RECORD = "\x01"
"""Begins a commit in the output of `git log`: no path holds it."""


@dataclass(frozen=True)
class Version:
    """One committed version of a measurement.

    Attributes
    ----------
    machine : str
        The folder that it lies in.
    commit : str
        Where it was committed.
    revision : str
        Of the code that was measured; "" where it isn't known.
    dirty : bool
        Whether files differed from that revision.
    date : str
        When it was measured, ISO 8601.
    values : dict of str to Observed
        By quantity.
    """

    machine: str
    commit: str
    revision: str
    dirty: bool
    date: str
    values: dict[str, Observed]


@dataclass(frozen=True)
class Unread:
    """A version that is left out, and why."""

    path: str
    commit: str
    why: str


@dataclass(frozen=True)
class History:
    """All versions of one kind of measurement, in order of time.

    Attributes
    ----------
    kind : str
    versions : tuple of Version
        Of all machines.
    unread : tuple of Unread
    cut : bool
        Whether the clone is shallow, so that older versions may be missing.
    """

    kind: str
    versions: tuple[Version, ...]
    unread: tuple[Unread, ...] = ()
    cut: bool = False

    @property
    def machines(self) -> tuple[str, ...]:
        """Machines that measured, in order of name."""
        return tuple(sorted({version.machine for version in self.versions}))

    @property
    def quantities(self) -> tuple[str, ...]:
        """Quantities of any version, in the order of the newest that has them."""
        newest_first = reversed(self.versions)
        return tuple(dict.fromkeys(name for version in newest_first for name in version.values))

    def of(self, machine: str) -> tuple[Version, ...]:
        """Return the versions of one machine, in order of time."""
        return tuple(version for version in self.versions if version.machine == machine)


def read_history(kind: str = "targets", pattern: str | None = None) -> History:
    """Read all committed versions of a kind of measurement.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    pattern : str, optional
        Keeps only quantities that match, such as "break-*/kernel".

    Raises
    ------
    BenchError
        Where the kind is unknown, this is no checkout, git is missing, nothing was ever committed,
        no version can be read, or no quantity matches.
    GitError
        Where git refuses the repository.
    """
    if kind not in KINDS:
        raise BenchError(f"kind must be one of {', '.join(KINDS)}, got {kind!r}")
    root = _checked_root()
    paths = _committed(root, kind)
    found = [one for path in paths for one in _versions(root, kind, path)]
    versions = [one for one in found if isinstance(one, Version)]
    unread = tuple(one for one in found if isinstance(one, Unread))
    if not versions:
        whys = "; ".join(f"{one.path} at {one.commit[:10]}: {one.why}" for one in unread)
        raise BenchError(f"no committed measurement of `{kind}` can be read: {whys}. Measure again")
    versions.sort(key=lambda one: (one.date, one.machine))
    cut = run_git(root, "rev-parse", "--is-shallow-repository") == "true"
    history = History(kind, tuple(versions), unread, cut)
    return history if pattern is None else _matching(history, pattern)


def _matching(history: History, pattern: str) -> History:
    names = {name for name in history.quantities if fnmatchcase(name, pattern)}
    if not names:
        known = ", ".join(history.quantities[:8])
        raise BenchError(
            f"`--quantity` must match a quantity of `{history.kind}`, got {pattern!r}. There are "
            f"{len(history.quantities)}, such as {known}"
        )
    versions = [
        replace(one, values={name: v for name, v in one.values.items() if name in names})
        for one in history.versions
    ]
    kept = tuple(version for version in versions if version.values)
    return replace(history, versions=kept)


def _checked_root() -> Path:
    root = measurements.CHECKOUT
    if not (root / "pyproject.toml").is_file() or not (root / ".git").exists():
        raise BenchError(
            f"the history of measurements is read from git, and {root} is no checkout of "
            "ghostball. Clone the repository and run it there"
        )
    if shutil.which("git") is None:
        raise BenchError("the history of measurements is read by `git`, which isn't installed")
    return root


def _committed(root: Path, kind: str) -> list[str]:
    """Return the committed files of a kind, relative to the root."""
    listed = run_git(root, "ls-files", "-z", "--", PLACE).split("\0")
    kinds = {Path(path).stem for path in listed if path.endswith(".json")}
    if kind not in kinds:
        there = f"There are: {', '.join(sorted(kinds))}" if kinds else "There is none at all"
        bench = "stress --json" if kind == "stress" else f"bench {kind} --store"
        raise BenchError(
            f"no measurement of `{kind}` is committed in {PLACE}. {there}. "
            f"`ghostball {bench.replace('bench targets', 'bench')}` makes one"
        )
    return sorted(path for path in listed if Path(path).name == f"{kind}.json")


def _versions(root: Path, kind: str, path: str) -> Iterator[Version | Unread]:
    """Yield what each commit that changed a file made of it, the newest first."""
    for commit, name in _commits(root, path):
        try:
            text = run_git(root, "show", f"{commit}:{name}")
            measured = observed_in(kind, text)
        except (GitError, ValidationError) as error:
            why = told(error) if isinstance(error, ValidationError) else str(error)
            yield Unread(name, commit, why)
            continue
        git = measured.environment.get("git") or {}
        yield Version(
            machine=Path(path).parent.name,
            commit=commit,
            revision=str(git.get("revision", "")),
            dirty=bool(git.get("dirty", False)),
            date=str(measured.environment.get("date", "")),
            values=measured.values,
        )


def _commits(root: Path, path: str) -> Iterator[tuple[str, str]]:
    """Yield each commit that changed a file, and how it was called there, the newest first.

    Not `git log --follow`: where a file is new it looks for one to be a copy of, and finds another
    machine's measurement, which is as like as can be.
    """
    log = run_git(
        root,
        *("-c", "core.quotepath=off"),  # names beyond ASCII as they are
        "log",
        "--topo-order",
        "--find-renames",
        f"--format={_RECORD}%H",
        "--name-status",
        "--",
        PLACE,
    )
    name = path
    for record in log.split(_RECORD)[1:]:
        commit, *changes = record.split("\n")
        for change in changes:  # "M\tPATH", "D\tPATH", or "R100\tOLD\tNEW"
            status, *paths = change.split("\t")
            if paths and paths[-1] == name and status != "D":
                yield commit, name
                name = paths[0]
