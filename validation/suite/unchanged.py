"""Which cases needn't run again: all that decides what they measure is as it was.

That is hashed in two parts. The *inputs* of a case: the scene, the engine with all its settings,
the criteria, the truth asked for, the metrics. And the *code*, one hash for all cases of a run: the
sources of `engine`, `reference_adapters` and `validation`, the interpreter, the versions of the
packages that compute, the machine, and what in the environment acts on compilers and libraries.
What is unchanged is then a query, of the store that `validation.runs.runner` is given. The
hashes are generous: an edited comment runs everything again, which costs time; a change that is
missed would cost the results their meaning.

The code of an engine of another project, and the versions of what it imports, are a part of the
hash of the code of its own records.

Two things can't be hashed, so such cases always run: an engine that another package brings may read
files of any kind; a case that failed, or stopped early, may have done so for a reason
outside of all this, such as a limit of time. Of an installed package that computes
only the version is known: after an edit in place, run with `--rerun`.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
import sys
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cache
from typing import Any

from ghostball.model import Scene
from ghostball.reference_adapters.base import EngineError
from ghostball.reference_adapters.workers.process import installed
from ghostball.validation.checks.law import Asked
from ghostball.validation.parallel.sources import (
    SourcesError,
    code_kind,
    engine_code,
    hash_sources,
    source_folders,
    versions,
)
from ghostball.validation.results.database import SCHEMA
from ghostball.validation.results.environment import cpu_flags, cpu_name
from ghostball.validation.results.record_store import Name
from ghostball.validation.results.records import CaseRecord

VARIABLES = ("NUMBA_", "NPY_", "MPMATH_", "LD_", "DYLD_", "GLIBC_", "OMP_", "OPENBLAS_", "MKL_")
"""Beginnings of environment variables that act on compilers or libraries."""

HARMLESS = frozenset({"NUMBA_CACHE_DIR", "NUMBA_COLOR_SCHEME", "NUMBA_NUM_THREADS"})
"""Those of them that change where things lie or how they look, and no result."""


def measured_between(reused: Collection[CaseRecord]) -> dict[str, Any]:
    """Return what the environment of a run says of the cases that are reused."""
    dates = sorted(case.measured for case in reused)
    first, last = (dates[0], dates[-1]) if dates else (None, None)
    return {"cases": len(dates), "measured_first": first, "measured_last": last}


def inputs_hash(
    scene: Scene,
    label: str,
    settings: Mapping[str, Any],
    asked: Asked,
    truth: str | None,
    metrics: Sequence[str] | None,
) -> str:
    """Return the hash of all that one case is asked to do.

    `label`: the engine as asked for.
    `settings`: all its settings, as plain values.
    `truth`: what the scene's criteria ask for.
    `metrics`: those that are computed; None is all.
    """
    return hash_of(
        {
            "schema": SCHEMA,
            "scene": scene.model_dump(mode="json", by_alias=True),
            "label": label,
            "settings": settings,
            "asked": asked.plain(),
            "truth": truth,
            "metrics": metrics,
        }
    )


def code_hash() -> str:
    """Return the hash of the code that runs here; "" where its sources can't be found."""
    try:
        return hash_of(describe_code())
    except SourcesError:
        return ""


def code_with_engines(code: str) -> Callable[[Name], str]:
    """Return what gives the hash of all code that makes the record of a name, as a store asks for.

    `code`: hash of the code that makes all records.

    The last part of a name is the label of an engine, whose own code is in the hash if it is of
    another project. "" if that isn't known.
    """

    @cache
    def of_engine(label: str) -> str:
        try:
            kind = code_kind(label)
            return hash_of([code, engine_code(kind)]) if kind and code else code
        except (EngineError, SourcesError):  # it may not be here any more
            return ""

    return lambda name: of_engine(name[-1])


def describe_code() -> dict[str, Any]:
    """Return what the hash of the code is made of, as plain values."""
    return {
        "sources": _loaded_sources(),
        "python": [sys.version, sys.implementation.name],
        "versions": versions(),
        "workers": dict(installed()),
        "machine": [platform.platform(), platform.machine(), cpu_name(), cpu_flags()],
        "variables": {
            name: value
            for name, value in sorted(os.environ.items())
            if name.startswith(VARIABLES) and name not in HARMLESS
        },
    }


@cache  # modules stay in memory as they were loaded, whatever becomes of their files
def _loaded_sources() -> str:
    return hash_sources(source_folders())


def hash_of(values: Any) -> str:
    """Return the hash of plain values."""
    # Floats are written so that they read back to the same bits; -0.0 keeps its sign.
    text = json.dumps(values, sort_keys=True, ensure_ascii=True, allow_nan=True)
    return hashlib.sha256(text.encode()).hexdigest()
