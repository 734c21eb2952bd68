"""Find the cases of an earlier run that can be reused, because all their inputs are unchanged.

Two hashes decide. The *inputs* of a case: the scene, the engine with all its settings, the
criteria, the kind of reference result, the metrics. The *code*, one hash for all cases of a run:
the sources of `model`, `engine`, `reference_adapters` and `validation`, the interpreter, the
versions of the packages that compute, the machine, and the environment variables that affect
compilers and libraries. The store of `validation.runs.runner` is then queried for records with the
same hashes. The hashes cover more than necessary: editing a comment makes all cases run again,
which costs only time; an undetected change would make results wrong.

For an engine of another project, the hash of the code of its records includes its own code and the
versions of the packages that it imports.

Two kinds of cases always run, because hashes can't cover them: an engine from another package may
read files of any kind, and a case that failed or stopped early may have done so for an outside
reason such as a time limit. For an installed package that computes, only its version is hashed:
after editing its files, run with `--rerun`.
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
from ghostball.validation.checks.requirements import Requirements
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
"""Prefixes of environment variables that affect compilers or libraries."""

HARMLESS = frozenset({"NUMBA_CACHE_DIR", "NUMBA_COLOR_SCHEME", "NUMBA_NUM_THREADS"})
"""Exceptions: variables that affect only locations, appearance or the number of threads."""


def measured_between(reused: Collection[CaseRecord]) -> dict[str, Any]:
    """Return the description of the reused cases for the environment of a run."""
    dates = sorted(case.measured for case in reused)
    first, last = (dates[0], dates[-1]) if dates else (None, None)
    return {"cases": len(dates), "measured_first": first, "measured_last": last}


def inputs_hash(
    scene: Scene,
    label: str,
    settings: Mapping[str, Any],
    asked: Requirements,
    truth: str | None,
    metrics: Sequence[str] | None,
) -> str:
    """Return the hash of all inputs of one case.

    `label`: the engine with its settings, as the user wrote it.
    `settings`: all its settings, as plain values.
    `truth`: the kind of reference result that the criteria of the scene ask for.
    `metrics`: the metrics that are computed; None: the usual ones, and those with a limit.
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
    """Return the hash of the code that runs here; "" if its sources can't be found."""
    try:
        return hash_of(describe_code())
    except SourcesError:
        return ""


def code_with_engines(code: str) -> Callable[[Name], str]:
    """Return a function from the name of a record to the hash of all code that makes the record.

    `code`: hash of the code that makes all records.

    The last part of a name is the label of an engine. If the engine belongs to another project, the
    hash includes its own code. The function returns "" if that code is unknown.
    """

    @cache
    def of_engine(label: str) -> str:
        try:
            kind = code_kind(label)
            return hash_of([code, engine_code(kind)]) if kind and code else code
        except (EngineError, SourcesError):  # the engine may no longer be installed
            return ""

    return lambda name: of_engine(name[-1])


def describe_code() -> dict[str, Any]:
    """Return the values from which the hash of the code is computed."""
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


@cache  # modules stay in memory as loaded, even if their files change
def _loaded_sources() -> str:
    return hash_sources(source_folders())


def hash_of(values: Any) -> str:
    """Return the hash of plain values."""
    # Floats are written so that they read back to the same bits; -0.0 keeps its sign.
    text = json.dumps(values, sort_keys=True, ensure_ascii=True, allow_nan=True)
    return hashlib.sha256(text.encode()).hexdigest()
