"""Which cases needn't run again: all that decides what they measure is as it was.

That is hashed in two parts. The *inputs* of a case: the scene, the engine with all its settings,
the criteria, the truth asked for, the metrics. And the *code*, one hash for all cases: the sources
of `engine`, `reference_adapters` and `validation`, the interpreter, the packages that compute, the
machine, and what in the environment acts on compilers and libraries. The hashes are generous: an
edited comment runs everything again, which costs time; a change that is missed would cost the
results their meaning.

Two things can't be hashed, so such cases always run: an engine that another package brings depends
on whatever that package loads; a case that failed, or stopped early, may have done so for a reason
outside of all this, such as a limit of time.

Modules stay in memory as they were imported, while their files may be edited and packages
installed. So these are looked at when this module is imported, before each run and after each case:
once they differ, or changed after `engine` was imported, which comes before all else of ours,
nothing is taken over, and what is measured is marked to be run again.

A library is told by the list of its files that was written when it was installed. So an edit of an
installed file in place isn't seen; and where a library is installed editable, so that the list
doesn't name its sources, nothing is taken over at all.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

from engine import _IMPORTED_NS, Scene
from reference_adapters.registry import engine_class, parse_spec
from validation.checks.criteria import Criterion
from validation.parallel.sources import (
    LIBRARIES,
    OUR_PACKAGES,
    SourcesError,
    code_entries,
    hash_sources,
    source_folders,
)
from validation.results.environment import cpu_flags, cpu_name
from validation.results.files import hash_of_file
from validation.results.records import COMPLETE_STATUSES, SCHEMA, CaseRecord

VARIABLES = (
    *("NUMBA_", "NPY_", "NUMPY_", "MPMATH_", "LD_", "DYLD_", "GLIBC_"),
    *("OMP_", "OPENBLAS_", "MKL_", "PYTHON"),
)
"""Beginnings of environment variables that act on compilers, libraries or the interpreter."""

HARMLESS = frozenset(
    {
        *("PYTHONPATH", "PYTHONHASHSEED", "PYTHONUNBUFFERED", "PYTHONDONTWRITEBYTECODE"),
        *("PYTHONPYCACHEPREFIX", "PYTHONSTARTUP", "PYTHONIOENCODING", "PYTHONWARNINGS"),
        *("CACHE_DIR", "COLOR_SCHEME", "NUMBA_NUM_THREADS", "NUMBA_DEFAULT_NUM_THREADS"),
    }
)
"""Variables and settings of numba that change where things lie or how they look, no result.

PYTHONPATH decides which files are imported; these are hashed themselves.
"""

Pair = tuple[str, str]
"""A scene's name and an engine's label."""


@dataclass(frozen=True)
class Code:
    """The code of a run, as it was when the run was planned.

    Attributes
    ----------
    hash : str
        "" where the code that is loaded can't be told; nothing is then taken over, now or later.
    why : str
        Why it can't be told; else "".
    """

    hash: str
    why: str = ""

    @classmethod
    def now(cls) -> Code:
        """Describe and hash the code that this process has loaded."""
        if not _LOADED:
            return cls("", "the source files of ghostball can't be read here")
        if _look() != _LOADED or _changed_after(_LOADED, _IMPORTED_NS):
            return cls("", "files of code changed since this process loaded them")
        if editable := [name for name in LIBRARIES if _is_editable(name)]:
            names = ", ".join(editable)
            return cls("", f"installed editable, so that their code can't be told: {names}")
        return cls(_hash(describe_code()))

    def holds(self) -> bool:
        """Whether the files of the code are still those that were loaded."""
        return bool(self.hash) and _look() == _LOADED


@dataclass(frozen=True, eq=False)
class Unchanged:
    """What a run takes over from the earlier results in its folder.

    Attributes
    ----------
    cases : dict of (str, str) to CaseRecord
        By scene and label, in the order of the run.
    stored : int
        How many results there are that could have been taken over.
    why : str
        Why none is, where the reason is one for all; else "".
    always : tuple of str
        Labels of engines that other packages bring: their cases always run.
    damaged : tuple of str
        Files of motion that are missing or damaged, so that their cases run again.
    """

    cases: Mapping[Pair, CaseRecord] = field(default_factory=dict)
    stored: int = 0
    why: str = ""
    always: tuple[str, ...] = ()
    damaged: tuple[str, ...] = ()


def find_unchanged(
    folder: Path,
    earlier: Sequence[CaseRecord],
    wanted: Mapping[Pair, str],
    code: Code,
    always: Sequence[str] = (),
) -> Unchanged:
    """Return the cases that needn't run again.

    Parameters
    ----------
    folder : Path
        The results folder.
    earlier : sequence of CaseRecord
        What was read from it; of two that are alike the last one counts.
    wanted : mapping of (str, str) to str
        `inputs_hash` of each case to be run, by scene and label; "" for those that always run.
    code : Code
        What would run them.
    always : sequence of str
        Labels of engines that other packages bring.
    """
    stored = [case for case in earlier if may_be_taken_over(case) and case.inputs_hash]
    if not code.hash:
        return Unchanged(stored=len(stored), why=code.why, always=tuple(always))
    same = {case.inputs_hash: case for case in stored if case.code_hash == code.hash}
    cases: dict[Pair, CaseRecord] = {}
    damaged: list[str] = []
    for pair, inputs in wanted.items():
        case = same.get(inputs) if inputs else None
        if case is None:
            continue
        if _motion_is_whole(folder, case):
            cases[pair] = replace(case, taken_over=True)
        else:
            damaged.append(str(case.motion))
    why = "the code or the environment changed" if stored and not same else ""
    return Unchanged(cases, len(stored), why, tuple(always), tuple(damaged))


def may_be_taken_over(case: CaseRecord) -> bool:
    """Whether a case came to an end that it would come to again: not to a failure or a limit."""
    return case.outcome == "not-representable" or (
        case.outcome == "ran" and case.status in COMPLETE_STATUSES
    )


def stamped(case: CaseRecord, inputs: str, code: Code) -> CaseRecord:
    """Return a case that has just been run with when that was and what it was made of."""
    case = replace(case, measured=datetime.now(UTC).isoformat(timespec="seconds"))
    if not inputs or not may_be_taken_over(case) or not code.holds():
        return case
    return replace(case, inputs_hash=inputs, code_hash=code.hash)


def dates_of(taken_over: Sequence[CaseRecord]) -> dict[str, Any]:
    """Return what `env.json` says of the cases that are taken over."""
    dates = sorted(case.measured for case in taken_over)
    first, last = (dates[0], dates[-1]) if dates else (None, None)
    return {"cases": len(dates), "measured_first": first, "measured_last": last}


def inputs_hash(
    scene: Scene,
    label: str,
    settings: Mapping[str, Any],
    criteria: Sequence[Criterion],
    truth: str | None,
    metrics: Sequence[str] | None,
    left_out: Sequence[str] = (),
) -> str:
    """Return the hash of all that one case is asked to do.

    Parameters
    ----------
    scene : Scene
    label : str
        The engine as asked for.
    settings : mapping
        All its settings, as plain values.
    criteria : sequence of Criterion
        Those that apply.
    truth : str or None
        What the scene's criteria ask for.
    metrics : sequence of str or None
        Those that are computed; None is all.
    left_out : sequence of str
        Metrics of criteria that aren't judged.
    """
    return _hash(
        {
            "schema": SCHEMA,
            "scene": scene.model_dump(mode="json", by_alias=True),
            "label": label,
            "settings": settings,
            "criteria": [criterion.model_dump(mode="json") for criterion in criteria],
            "truth": truth,
            "metrics": metrics,
            "left_out": left_out,
        }
    )


def is_ours(label: str) -> bool:
    """Whether an engine is one of this project, so that its code is known and hashed."""
    engine: Any = engine_class(parse_spec(label)[0])
    return str(engine.__module__).partition(".")[0] in OUR_PACKAGES


def describe_code() -> dict[str, Any]:
    """Return what the hash of the code is made of, as plain values."""
    return {
        "sources": hash_sources(source_folders()),
        "python": [sys.version, sys.implementation.name, sys.flags.optimize],
        "libraries": {name: _library(name) for name in LIBRARIES},
        "machine": [platform.platform(), platform.machine(), cpu_name(), cpu_flags()],
        "numba": _numba_settings(),
        "variables": {
            name: value
            for name, value in sorted(os.environ.items())
            if name.startswith(VARIABLES) and name not in HARMLESS
        },
    }


def _look() -> tuple[Any, ...]:
    """Return what shows that a source file was touched, or a package installed, without reading it.

    () where the sources can't be looked at. The time of the last change of a file's entry can't be
    set back, as that of its content can.
    """
    try:
        sources = [entry.path for folder in source_folders() for entry in code_entries(folder)]
        installed = [path for path in sys.path if path.rstrip(os.sep).endswith("-packages")]
        return tuple(
            (path, state.st_ino, state.st_size, state.st_mtime_ns, state.st_ctime_ns)
            for path in sorted(sources) + [path for path in installed if Path(path).is_dir()]
            for state in [os.stat(path)]
        )
    except (OSError, SourcesError):
        return ()


def _changed_after(look: tuple[Any, ...], instant: int) -> bool:
    """Whether anything in what `_look` returned changed after an instant [ns].

    On Windows by the time of content, for that of the entry is of its creation there. Elsewhere
    not: it may be set to any time, also to one that is yet to come.
    """
    return any((mtime if os.name == "nt" else ctime) > instant for *_, mtime, ctime in look)


_LOADED = _look()
"""The files of the code when this module was imported, and with it all that measures."""


@cache
def _is_editable(name: str) -> bool:
    """Whether a distribution is installed as a link to its sources (PEP 610, PEP 660)."""
    try:
        origin = json.loads(distribution(name).read_text("direct_url.json") or "{}")
    except PackageNotFoundError:
        return False
    return bool(origin.get("dir_info", {}).get("editable", False))


@cache
def _library(name: str) -> list[str] | None:
    """Return version and hash of the list of installed files, which has the hash of each; or None.

    The list tells two builds of one version apart.
    """
    try:
        found = distribution(name)
    except PackageNotFoundError:
        return None
    listed = found.read_text("RECORD") or ""
    return [found.version, hashlib.sha256(listed.encode()).hexdigest()]


def _numba_settings() -> dict[str, str]:
    """Return numba's settings, whether set by variable, by file or at run time.

    Without the number of threads: no kernel is parallel.
    """
    # Slow to import, and asked for only where something is about to be run or taken over.
    from numba import config  # noqa: PLC0415

    names = (name for name in dir(config) if name.isupper() and name not in HARMLESS)
    return {name: repr(getattr(config, name)) for name in names}


def _motion_is_whole(folder: Path, case: CaseRecord) -> bool:
    if case.motion is None:
        return True
    try:
        return hash_of_file(folder / case.motion) == case.motion_hash
    except OSError:
        return False


def _hash(values: Any) -> str:
    # Floats are written so that they read back to the same bits; -0.0 keeps its sign.
    text = json.dumps(values, sort_keys=True, ensure_ascii=True, allow_nan=True)
    return hashlib.sha256(text.encode()).hexdigest()
