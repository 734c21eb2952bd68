"""Errors and warnings of a run, as lines for any CI service and as annotations for GitHub.

A line `::error title=TITLE::MESSAGE` in the output of a step (a workflow command) makes an
annotation.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from ghostball.reports.error_changes import error_text, is_shifted
from ghostball.reports.outcome import Failure, failures
from ghostball.validation.baselines.regression import UNCOMPARED, Regression, SceneChange
from ghostball.validation.results.store import Results
from ghostball.validation.scenes import commands

SHOWN = 10
"""Number of errors, and number of warnings, that GitHub shows for a step."""

NAMED = 6
"""Largest number of scenes that a message names; more scenes are only counted."""


@dataclass(frozen=True)
class Finding:
    """An error or a warning; `about` names its scene or engine, the results, or the baselines."""

    level: Literal["error", "warning"]
    about: str
    title: str
    message: str


def findings(results: Results | None, regressions: Sequence[Regression]) -> list[Finding]:
    """Return the errors, then the warnings; `results` is None if only a comparison was made."""
    failed = [] if results is None else list(failures(results.cases))
    found = [*map(_of_failure, failed), *(() if results is None else _of_run(results))]
    lost = {(one.case.scene, one.case.label) for one in failed if one.check is None}
    for regression in regressions:
        found += _of_regression(regression, lost)
    return sorted(found, key=lambda one: one.level)


def notes(found: Sequence[Finding]) -> str:
    """Return annotations, up to `SHOWN` of each level; if there are more, the last counts them."""
    lines = []
    for level in ("error", "warning"):
        these = [one for one in found if one.level == level]
        few = these if len(these) <= SHOWN else these[: SHOWN - 1]
        lines += [note(level, one.title, one.message) for one in few]
        if rest := these[len(few) :]:
            lines.append(note(level, f"{len(rest)} more", ", ".join(one.title for one in rest)))
    return "".join(f"{line}\n" for line in lines)


def note(level: str, title: str, message: str) -> str:
    """Return one annotation, with title and message escaped for GitHub."""
    texts = f"Ghostball: {title}", message
    title, message = (
        text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A") for text in texts
    )
    return f"::{level} title={title.replace(':', '%3A').replace(',', '%2C')}::{message}"


def _of_failure(failure: Failure) -> Finding:
    case, finished = failure.case, failure.check is not None
    again = (commands.explain if finished else commands.simulate)(case.scene, case.label)
    title = f"{case.scene} {'fails a limit' if finished else 'did not finish'}"
    why = f" ({failure.reason})" if failure.reason else ""
    message = f"{case.label}: {failure.words}{why}\nTo repeat: {again}"
    return Finding("error", case.scene, title, message)


def _of_run(results: Results) -> Iterator[Finding]:
    """Yield findings about unavailable engines, and about an incomplete run."""
    missing = {one.label: one.reason for one in results.cases if one.outcome == "unavailable"}
    for label, reason in missing.items():
        yield Finding("warning", label, f"{label} is unavailable", reason)
    if results.state != "complete":
        said = f"the run is incomplete: {results.state}"
        yield Finding("error", str(results.path), "incomplete", said)


def _of_regression(regression: Regression, lost: set[tuple[str, str]]) -> Iterator[Finding]:
    for change in regression.scenes:
        shown = change.failed or change.change not in ("unchanged", "rounding")
        if change.change in UNCOMPARED or not shown:
            continue
        if (change.scene, regression.label) in lost or not (change.moved or not change.broken):
            continue  # the findings of the run already name this case
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
        yield f"To repeat: {change.command}"


def change_lines(change: SceneChange) -> Iterator[str]:
    """Yield the first difference of a shot from its baseline, and each different number."""
    if change.first_difference is not None:
        yield f"first difference: {change.first_difference.words}"
    yield from (one.words for one in (*change.counters, *change.metrics))
