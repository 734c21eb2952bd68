"""The gate: what a change of an engine changed, against accepted baselines.

>>> results = Results.open("out")                  # runs of an engine
>>> regression = compare_results(results, Path("baselines/ghostball"), whole=True)
>>> regression.outcome, [one.scene for one in regression.scenes if one.failed]
"""

from __future__ import annotations

from ghostball.validation.baselines.accept import (
    Acceptance,
    AcceptError,
    LimitsBrokenError,
    NotDeterministicError,
    NotFinishedError,
    NothingToAcceptError,
    UnjudgedError,
    accept,
    can_be_accepted,
)
from ghostball.validation.baselines.baseline import load_baseline
from ghostball.validation.baselines.gate import check_baselines, compare_results
from ghostball.validation.baselines.regression import (
    FirstDifference,
    Quantity,
    Regression,
    SceneChange,
    load_regression,
    load_regressions,
    save_regressions,
)
from ghostball.validation.baselines.revision import RevisionError

__all__ = [
    "AcceptError",
    "Acceptance",
    "FirstDifference",
    "LimitsBrokenError",
    "NotDeterministicError",
    "NotFinishedError",
    "NothingToAcceptError",
    "Quantity",
    "Regression",
    "RevisionError",
    "SceneChange",
    "UnjudgedError",
    "accept",
    "can_be_accepted",
    "check_baselines",
    "compare_results",
    "load_baseline",
    "load_regression",
    "load_regressions",
    "save_regressions",
]
