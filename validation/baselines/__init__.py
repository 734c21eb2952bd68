"""The gate: what a change of our engine changed, against accepted baselines or another revision.

>>> results = Results.open("out/regress")          # runs of our engine
>>> regression = compare_results(results, whole=True)    # against validation/baselines/accepted
>>> regression.outcome, [one.scene for one in regression.scenes if one.failed]
"""

from __future__ import annotations

from validation.baselines.accept import (
    Acceptance,
    AcceptError,
    LimitsBrokenError,
    accept,
    can_be_accepted,
)
from validation.baselines.against import compare_revisions
from validation.baselines.baseline import (
    Baseline,
    BaselineError,
    BaselineSchemaError,
    baseline_folder,
    load_baseline,
)
from validation.baselines.gate import check_baselines, compare_results
from validation.baselines.player import NotComparableError
from validation.baselines.regression import (
    FirstDifference,
    LoggedEvent,
    Quantity,
    Regression,
    SceneChange,
    TimeChange,
    Timing,
    load_regression,
    save_regression,
)
from validation.baselines.revision import RevisionError

__all__ = [
    "AcceptError",
    "Acceptance",
    "Baseline",
    "BaselineError",
    "BaselineSchemaError",
    "FirstDifference",
    "LimitsBrokenError",
    "LoggedEvent",
    "NotComparableError",
    "Quantity",
    "Regression",
    "RevisionError",
    "SceneChange",
    "TimeChange",
    "Timing",
    "accept",
    "baseline_folder",
    "can_be_accepted",
    "check_baselines",
    "compare_results",
    "compare_revisions",
    "load_baseline",
    "load_regression",
    "save_regression",
]
