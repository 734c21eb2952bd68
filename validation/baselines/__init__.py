"""The gate: what a change of an engine changed, against accepted baselines or another revision.

>>> results = Results.open("out/regress")          # runs of an engine
>>> regression = compare_results(results, Path("baselines/ghostball"), whole=True)
>>> regression.outcome, [one.scene for one in regression.scenes if one.failed]
"""

from __future__ import annotations

from ghostball.validation.baselines.accept import (
    Acceptance,
    AcceptError,
    LimitsBrokenError,
    NotDeterministicError,
    NothingToAcceptError,
    accept,
    can_be_accepted,
)
from ghostball.validation.baselines.against import compare_revisions
from ghostball.validation.baselines.baseline import (
    load_baseline,
)
from ghostball.validation.baselines.gate import check_baselines, compare_results
from ghostball.validation.baselines.player import NotComparableError
from ghostball.validation.baselines.regression import (
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
from ghostball.validation.baselines.revision import RevisionError

__all__ = [
    "AcceptError",
    "Acceptance",
    "FirstDifference",
    "LimitsBrokenError",
    "LoggedEvent",
    "NotComparableError",
    "NotDeterministicError",
    "NothingToAcceptError",
    "Quantity",
    "Regression",
    "RevisionError",
    "SceneChange",
    "TimeChange",
    "Timing",
    "accept",
    "can_be_accepted",
    "check_baselines",
    "compare_results",
    "compare_revisions",
    "load_baseline",
    "load_regression",
    "save_regression",
]
