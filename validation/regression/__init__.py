"""The gate: what a change of our engine changed, against accepted baselines or another revision."""

from __future__ import annotations

from validation.regression.records import (
    REGRESSION_FILE,
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

__all__ = [
    "REGRESSION_FILE",
    "FirstDifference",
    "LoggedEvent",
    "Quantity",
    "Regression",
    "SceneChange",
    "TimeChange",
    "Timing",
    "load_regression",
    "save_regression",
]
