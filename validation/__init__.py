"""The suite that says which engine is right: scenes, metrics, truth, criteria, stored results."""

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
