"""Compare runs with accepted baselines, and accept new baselines.

>>> gate = Gate.of("ghostball", Path("baselines"))
>>> regression = compare_results(Results.open("out"), gate, whole=True)
>>> regression.outcome, [one.scene for one in regression.scenes if one.failed]

`compare` compares two records of one scene, by three rules. `baseline` reads and writes an accepted
record. `gate` compares a run with the accepted records. `accept` replaces the accepted records.
"""

from __future__ import annotations

from ghostball.validation.baselines.accept import (
    Acceptance,
    AcceptError,
    NothingToAcceptError,
    RefusedError,
    accept,
)
from ghostball.validation.baselines.baseline import load_baseline
from ghostball.validation.baselines.compare import compare
from ghostball.validation.baselines.compared_run import ComparedRun
from ghostball.validation.baselines.gate import Gate, compare_case, compare_results
from ghostball.validation.baselines.regression import (
    FirstDifference,
    Regression,
    SceneChange,
    ValueChange,
    load_regression,
    load_regressions,
    save_regressions,
)
from ghostball.validation.baselines.revision import RevisionError

__all__ = [
    "AcceptError",
    "Acceptance",
    "ComparedRun",
    "FirstDifference",
    "Gate",
    "NothingToAcceptError",
    "RefusedError",
    "Regression",
    "RevisionError",
    "SceneChange",
    "ValueChange",
    "accept",
    "compare",
    "compare_case",
    "compare_results",
    "load_baseline",
    "load_regression",
    "load_regressions",
    "save_regressions",
]
