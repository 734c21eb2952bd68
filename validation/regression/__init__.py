"""The gate: what a change of our engine changed, against accepted baselines or another revision.

>>> results = ResultsFolder.load("out/regress")          # runs of our engine
>>> regression = compare_results(results, whole=True)    # against validation/baselines
>>> regression.outcome, [one.scene for one in regression.scenes if one.failed]
"""

from __future__ import annotations

from validation.files import REGRESSION_FILE
from validation.regression.accept import (
    Acceptance,
    AcceptError,
    LimitsBrokenError,
    accept,
    can_be_accepted,
)
from validation.regression.against import compare_revisions
from validation.regression.baseline import (
    Baseline,
    BaselineError,
    BaselineSchemaError,
    baseline_folder,
    load_baseline,
)
from validation.regression.calibrate import calibrate
from validation.regression.gate import check_baselines, compare_results, machine_scenes
from validation.regression.player import NotComparableError
from validation.regression.records import (
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
from validation.regression.revision import RevisionError
from validation.regression.timing import (
    MachineTimes,
    TimesError,
    load_times,
    save_times,
    time_scenes,
    times_path,
)

__all__ = [
    "REGRESSION_FILE",
    "AcceptError",
    "Acceptance",
    "Baseline",
    "BaselineError",
    "BaselineSchemaError",
    "FirstDifference",
    "LimitsBrokenError",
    "LoggedEvent",
    "MachineTimes",
    "NotComparableError",
    "Quantity",
    "Regression",
    "RevisionError",
    "SceneChange",
    "TimeChange",
    "TimesError",
    "Timing",
    "accept",
    "baseline_folder",
    "calibrate",
    "can_be_accepted",
    "check_baselines",
    "compare_results",
    "compare_revisions",
    "load_baseline",
    "load_regression",
    "load_times",
    "machine_scenes",
    "save_regression",
    "save_times",
    "time_scenes",
    "times_path",
]
