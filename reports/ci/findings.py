"""What fails in a run, or moved and may, for the lines of any CI and for the notes of GitHub.

Notes are workflow commands: lines `::error title=TITLE::MESSAGE` that a step prints.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from ghostball.reports.outcome import bad_cases
from ghostball.reports.shift import error_text, is_shifted
from ghostball.validation.baselines.regression import (
    UNCOMPARED,
    Regression,
    SceneChange,
)
from ghostball.validation.checks.verdict import unfinished_text
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.results.store import Results
from ghostball.validation.scenes import commands

SHOWN = 10
"""GitHub shows so many errors of a step, and as many warnings; it drops the rest in silence."""

NAMED = 6
"""More scenes than this are counted, not named."""


@dataclass(frozen=True)
class Finding:
    """One thing that fails, or that moved and may; `about` names its scene, or what else it is."""

    level: Literal["error", "warning"]
    about: str
    title: str
    message: str


def findings(results: Results | None, regressions: Sequence[Regression]) -> list[Finding]:
    """Return what fails, then what moved and may; `results`: None for a comparison alone."""
    found: list[Finding] = []
    bad = [] if results is None else bad_cases(results)
    for case in bad:
        found += _of_case(case)
    if results is not None:
        found += _of_run(results)
    lost = {(case.scene, case.label) for case in bad if unfinished_text(case)}
    for regression in regressions:
        found += _of_regression(regression, lost)
    return sorted(found, key=lambda one: one.level)


def notes(found: Sequence[Finding]) -> str:
    """Return findings as notes, as many as are shown; the last of each level counts the others."""
    lines = []
    for level in ("error", "warning"):
        these = [one for one in found if one.level == level]
        few = these if len(these) <= SHOWN else these[: SHOWN - 1]
        lines += [note(level, one.title, one.message) for one in few]
        if rest := these[len(few) :]:
            lines.append(note(level, f"{len(rest)} more", ", ".join(one.title for one in rest)))
    return "".join(f"{line}\n" for line in lines)


def note(level: str, title: str, message: str) -> str:
    """Return one note, escaped so that neither its title nor its message ends early."""
    texts = f"Ghostball: {title}", message
    title, message = (
        text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A") for text in texts
    )
    return f"::{level} title={title.replace(':', '%3A').replace(',', '%2C')}::{message}"


def _of_case(case: CaseRecord) -> Iterator[Finding]:
    again = f"Again: {commands.explain(case.scene, case.label)}"
    if why := unfinished_text(case):
        again = f"Again: {commands.simulate(case.scene, case.label)}"
        message = f"{case.label} did not finish: {why}\n{again}"
        yield Finding("error", case.scene, f"{case.scene} did not finish", message)
    for check in case.checks:
        if check.passed is False:
            message = f"{case.label}: {check.sentence} ({check.reason})\n{again}"
            yield Finding("error", case.scene, f"{case.scene} breaks a limit", message)


def _of_run(results: Results) -> Iterator[Finding]:
    """Yield which engines could not be tried, and whether the run is whole."""
    missing = {one.label: one.reason for one in results.cases if one.outcome == "unavailable"}
    for label, reason in missing.items():
        yield Finding("warning", label, f"{label} is unavailable", reason)
    if results.state != "complete":
        said = f"the run is not complete: {results.state}"
        yield Finding("error", str(results.path), "not complete", said)


def _of_regression(regression: Regression, lost: set[tuple[str, str]]) -> Iterator[Finding]:
    for change in regression.scenes:
        shown = change.failed or change.change not in ("unchanged", "rounding")
        if change.change in UNCOMPARED or not shown:
            continue
        if (change.scene, regression.label) in lost or not (change.moved or not change.broken):
            continue  # what it did is said of its run
        yield Finding(
            "error" if change.failed else "warning",
            change.scene,
            f"{change.scene}: {change.words}",
            "\n".join(_lines(regression, change)),
        )
    missing = [one.scene for one in regression.scenes if one.change in UNCOMPARED]
    if missing and regression.fail_on != "limits":
        command = commands.regress(engine=regression.label)
        which = ", ".join(missing) if len(missing) <= NAMED else f"{len(missing)} scenes"
        message = (
            f"{regression.label} can't be compared with a baseline in {which}. Run `{command}`, "
            "check the results, accept them with `ghostball accept`, and commit the folder of "
            "baselines"
        )
        yield Finding("error", "baselines", "no baseline", message)
    for warning in regression.warnings:
        yield Finding("warning", "baselines", "comparison with baselines", warning)


def _lines(regression: Regression, change: SceneChange) -> Iterator[str]:
    off = f", rest error {error_text(change)}" if is_shifted(change) else ""
    yield f"{regression.label}: {change.words}{off}"
    yield change.summary
    yield from change_lines(change)
    if change.command:
        yield f"Again: {change.command}"


def change_lines(change: SceneChange) -> Iterator[str]:
    """Yield where a shot first differs from its baseline, and each number that differs."""
    if change.first_difference is not None:
        yield f"first difference: {change.first_difference.words}"
    yield from (one.words for one in (*change.counters, *change.metrics))
