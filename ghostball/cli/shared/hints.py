"""Hints after the verdicts: what failures have in common, the next command, untested features."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rich.markup import escape

from ghostball.reference_adapters import EngineError, make_engine, names_class
from ghostball.reports.accuracy import allowed_text, allowing_check
from ghostball.reports.style import format_length
from ghostball.validation.checks.verdict import Verdict, few_ends_judged, is_unfinished, verdict_of
from ghostball.validation.results.quantities import listed
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.scenes import commands
from ghostball.validation.suite.hints import (
    features_tested,
    shared,
    simplest,
    unsupported_features,
    untested_features,
)

NAMES_LISTED = 4
"""Number of names in a line; the rest are counted."""


def hints(cases: Sequence[CaseRecord], labels: Sequence[str]) -> Iterator[str]:
    """Yield hints about each named engine."""
    for label in labels:
        own = [case for case in cases if case.label == label]
        if said := few_ends_judged(own):
            yield f"{escape(label)}: {said}"
        yield from _failures(own, label)
        yield from _largest_passed(own, label)
        if names_class(label):  # an engine of the user, given as module:name
            yield from coverage(own, label)


def coverage(own: Sequence[CaseRecord], label: str) -> Iterator[str]:
    """Yield the features that an engine doesn't support, and those that no scene tested."""
    name = escape(label)
    if missing := unsupported_features(own):
        unable = sum(verdict_of(case) is Verdict.NOT_REPRESENTABLE for case in own)
        counted = [f"{what} ({count})" for what, count in missing.items()]
        few = listed(counted, NAMES_LISTED)
        yield f"[dim]{name} doesn't support {unable} of these scenes (–). Missing: {few}[/]"
    try:
        found = untested_features(make_engine(label), set().union(*map(features_tested, own)))
    except EngineError:
        return
    scenes = " ".join(dict.fromkeys(filter(None, found.values())))
    parts = []
    for is_shipped, what in (
        (True, f"test with `ghostball validate {scenes} -e {label}`"),
        (False, "no shipped scene that it supports tests this"),
    ):
        if names := [one.value for one, scene in found.items() if bool(scene) is is_shipped]:
            parts.append(f"{listed(names, NAMES_LISTED)}: {what}")
    if parts:
        said = escape("; ".join(parts))
        yield f"[yellow]{name} claims features that no scene tested:[/] {said}"


def _failures(own: Sequence[CaseRecord], label: str) -> Iterator[str]:
    bad = [case for case in own if verdict_of(case) is Verdict.FAIL]
    crashed = [case for case in own if is_unfinished(case)]
    played = [case for case in own if case.outcome == "ran" and case not in bad + crashed]
    if said := shared(bad, played):
        yield f"Scenes that fail on {escape(label)}: {escape(said)}"
    if (one := simplest(bad)) is not None:
        yield f"next: `{escape(commands.explain(one.scene, label))}` shows what is wrong"
    elif (one := simplest(crashed)) is not None:
        yield f"next: `{escape(commands.simulate(one.scene, label))}` shows where it stopped"


def _largest_passed(own: Sequence[CaseRecord], label: str) -> Iterator[str]:
    """Yield why the largest error passed, and the command that finds its cause."""
    found = [(case.accuracy, case, allowing_check(case)) for case in own]
    errors = [(one.error or 0.0, case, check) for one, case, check in found if one and check]
    if not errors:
        return
    error, case, check = max(errors, key=lambda one: one[0])
    largest = f"the largest error that a limit allowed is {format_length(error)} in {case.scene}"
    yield escape(f"{label}: {largest}, {allowed_text(case)}. {check.reason}")
    failed = any(one.broken or is_unfinished(one) for one in own)
    if names_class(label) and not failed:  # else a failure comes first
        command = escape(commands.explain(case.scene, label))
        yield f"next: `{command}` shows what causes this error"
