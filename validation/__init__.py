"""The suite that says which engine is right: scenes, metrics, truth, criteria, stored results."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from validation.criteria import Criteria, CriteriaError, Criterion, criteria_beside
    from validation.junit import junit_xml, write_junit
    from validation.library import find_scene, scene_names, select
    from validation.metric_table import METRICS, Metric
    from validation.records import CaseRecord, Check, Motion
    from validation.store import ResultsError, ResultsFolder
    from validation.suite import DEFAULT_ENGINES, Outcome, criteria_beside_paths, run_suite
    from validation.truth import Truth, TruthError, truth_of
    from validation.verdict import RestError, Verdict, verdict_of

__all__ = [
    "DEFAULT_ENGINES",
    "METRICS",
    "CaseRecord",
    "Check",
    "Criteria",
    "CriteriaError",
    "Criterion",
    "Metric",
    "Motion",
    "Outcome",
    "RestError",
    "ResultsError",
    "ResultsFolder",
    "Truth",
    "TruthError",
    "Verdict",
    "criteria_beside",
    "criteria_beside_paths",
    "find_scene",
    "junit_xml",
    "run_suite",
    "scene_names",
    "select",
    "truth_of",
    "verdict_of",
    "write_junit",
]

_MODULES = {
    "validation.criteria": ("Criteria", "CriteriaError", "Criterion", "criteria_beside"),
    "validation.junit": ("junit_xml", "write_junit"),
    "validation.library": ("find_scene", "scene_names", "select"),
    "validation.metric_table": ("METRICS", "Metric"),
    "validation.records": ("CaseRecord", "Check", "Motion"),
    "validation.store": ("ResultsError", "ResultsFolder"),
    "validation.suite": ("DEFAULT_ENGINES", "Outcome", "criteria_beside_paths", "run_suite"),
    "validation.truth": ("Truth", "TruthError", "truth_of"),
    "validation.verdict": ("RestError", "Verdict", "verdict_of"),
}
"""Where each name is, imported when it is asked for: a process that needs one part of this package,
such as one that does tasks, would else take a second to import all of it."""


def __getattr__(name: str) -> Any:
    for module, names in _MODULES.items():
        if name in names:
            return getattr(import_module(module), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
