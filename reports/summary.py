"""What a CI shows of a run: Markdown for a page of GitHub Actions, plain lines for any other.

    >>> from ghostball.reports import summary_markdown
    >>> print(summary_markdown(Results.open("out"), load_regression(Path("out"))))

Made from stored results alone, like the report.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from ghostball.engine import GhostballError
from ghostball.reference_adapters.output import harmless
from ghostball.reports.markdown_parts import many, one_line, table_of
from ghostball.reports.outcome import (
    CHANGES,
    bad_cases,
    base_text,
    kind_text,
    kinds_text,
    of_comparison,
    of_limits,
    overall,
)
from ghostball.reports.shots import NUMBERS_KEY, cell_text, legend_text
from ghostball.validation.baselines.junit import UNCOMPARED, moved_text
from ghostball.validation.baselines.regression import Quantity, Regression, SceneChange
from ghostball.validation.checks.verdict import Verdict, unfinished_text, verdict_of
from ghostball.validation.results.files import write_whole
from ghostball.validation.results.store import CaseRecord, Results
from ghostball.validation.scenes import commands

LIMIT = 200_000
"""Bytes that a summary stays below; GitHub refuses a step's summary above 1 MiB."""

CELL = 400
"""Characters of a cell: an error message may be a whole page."""

_UNMOVED = ("identical", "rounding-only")


def summary_markdown(
    results: Results | None, regression: Regression | None, *, limit: int = LIMIT
) -> str:
    """Return the summary as Markdown: the verdict, what changed, what failed, all verdicts.

    Parameters
    ----------
    results : Results or None
        None where only a comparison was made.
    regression : Regression or None
    limit : int
        Bytes (UTF-8) that it stays below. Rows that don't fit are left out, and counted.
    """
    blocks = [_Block("\n\n".join(_headlines(results, regression)))]
    if regression is not None:
        blocks += _changes(regression)
    if results is not None:
        blocks += _failures(results)
        blocks.append(_matrix(results))
    return _fitted(blocks, limit)


def summary_text(results: Results | None, regression: Regression | None) -> str:
    """Return the summary as lines `SCENE: LEVEL: MESSAGE`, errors and warnings first.

    The level is "error", "warning" or "note"; the last lines, of `ghostball`, are the verdicts.
    """
    lines = [] if results is None else list(_case_lines(results))
    if regression is not None:
        lines += _change_lines(regression)
    lines += [
        ("ghostball", "note" if sign == "✓" else "error", words)
        for sign, words in _verdicts(results, regression)
    ]
    return harmless(
        "".join(f"{place}: {level}: {' '.join(words.split())}\n" for place, level, words in lines)
    )


def add_summary(text: str, path: str | Path) -> None:
    """Add a summary to a file, which others may have begun, as GitHub's steps do to theirs.

    Raises
    ------
    GhostballError
        Where it can't be written.
    """
    target = Path(path)
    try:
        # One write: what reads meanwhile, or a full disk, finds all of it or an error.
        file = os.open(target, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o666)
        with os.fdopen(file, "ab") as opened:
            opened.write(text.encode())
    except OSError as error:
        raise _cannot_write(target, error) from error


def write_summary(text: str, path: str | Path) -> None:
    """Write a summary in place of what a file held, whole or not at all.

    Raises
    ------
    GhostballError
        Where it can't be written.
    """
    target = Path(path)
    try:
        write_whole(target, text)
    except OSError as error:
        raise _cannot_write(target, error) from error


def _cannot_write(target: Path, error: OSError) -> GhostballError:
    reason = error.strerror or type(error).__name__
    return GhostballError(f"{target}: can't write the summary: {reason}. Choose another file")


@dataclass(frozen=True)
class _Block:
    """A part of the page: its head whole, then as many lines as fit; `noun` is what a line is."""

    head: str
    lines: Sequence[str] = ()
    noun: str = "line"
    where: str = ""


def _fitted(blocks: Sequence[_Block], limit: int) -> str:
    """Put blocks together below a limit of bytes, never cutting within a line.

    A block takes at most half of what is left where others follow, so that a thousand failures
    don't hide what changed.
    """
    parts: list[str] = []
    left = limit - 2  # the last newline is one, and below is less than
    for k, block in enumerate(blocks):
        last = k == len(blocks) - 1
        room = (left if last else left // 2) - _size(_left_out(block, len(block.lines)))
        kept = [block.head]
        room -= _size(block.head) + 2
        for line in block.lines:
            room -= _size(line) + 1
            if room < 0:
                break
            kept.append(line)
        text = "\n".join(kept)
        missing = len(block.lines) - (len(kept) - 1)
        if missing:
            text += f"\n\n{_left_out(block, missing)}"
        parts.append(text)
        left -= _size(text) + 2
    return "\n\n".join(parts) + "\n"


def _left_out(block: _Block, count: int) -> str:
    where = f" {block.where}" if block.where else ""
    return f"*{many(count, f'more {block.noun}')} left out here, for want of room.{where}*"


def _size(text: str) -> int:
    return len(text.encode())


def _headlines(results: Results | None, regression: Regression | None) -> Iterator[str]:
    whole = overall(results, regression)
    yield f"## {whole.sign} Ghostball: {whole.word}"
    yield from (f"{sign} {words}" for sign, words in _verdicts(results, regression))


def _verdicts(results: Results | None, regression: Regression | None) -> list[tuple[str, str]]:
    """Return what came of it all, a sign and a sentence each; what is no pass stands first."""
    said = []
    if regression is not None:
        compared = of_comparison(regression)
        warned = f" {many(len(regression.warnings), 'warning')}." if regression.warnings else ""
        said.append((compared.sign, f"{compared.why}{warned}"))
    if results is not None:
        limits = of_limits(results)
        unfinished = "" if results.state == "complete" else f" {_unfinished(results)}"
        said.append((limits.sign, f"{limits.why} {_case_verdict(results)}.{unfinished}"))
    return sorted(said, key=lambda one: one[0] == "✓")


def _unfinished(results: Results) -> str:
    done = f"{len(results.cases)} of {many(results.planned, 'case')} are done"
    return f"The run is not complete ({results.state}): {done}."


def _case_verdict(results: Results) -> str:
    verdicts = [verdict_of(case) for case in results.cases]
    failed, crashed = verdicts.count(Verdict.FAIL), verdicts.count(Verdict.CRASHED)
    crashes = f", {crashed} did not finish" if crashed else ""
    return (
        f"{many(len(results.scene_names), 'scene')} on {many(len(results.labels), 'engine')}: "
        f"{verdicts.count(Verdict.PASS)} cases passed, {failed} failed{crashes}, "
        f"{verdicts.count(Verdict.LIMITS_HOLD)} keep their limits without a verdict on the outcome"
    )


def _changes(regression: Regression) -> Iterator[_Block]:
    told = [one for one in regression.scenes if _is_told(one)]
    before = [one for one in regression.scenes if not _is_told(one)]
    heading = f"### What changed against {base_text(regression)}"
    rest = f"\n\n{many(len(before), 'scene')} as before: {kinds_text(before)}." if before else ""
    if told:
        header = ["scene", "change", "what", "first difference", "command"]
        head = f"{heading}{rest}\n\n{_table_head(header)}"
        rows = [_row(_change_cells(change)) for change in _in_order(told)]
        where = "`ghostball regress` lists them all."
        yield _Block(head, rows, "scene", where)
    else:
        yield _Block(f"{heading}\n\nNothing.{rest}")
    notes = [*regression.warnings, *map(_stale, regression.stale)]
    if notes:
        yield _Block("### Warnings\n", [f"- {_cell(note)}" for note in notes], "warning")


def _is_told(change: SceneChange) -> bool:
    return change.failed or change.change not in _UNMOVED


def _in_order(changes: Sequence[SceneChange]) -> list[SceneChange]:
    """Return what fails first, then what could not be compared, then the rest."""
    return sorted(changes, key=lambda one: (not one.failed, one.change not in UNCOMPARED))


def _stale(scene: str) -> str:
    return f"{scene}: baseline of a scene that is no more"


def _change_cells(change: SceneChange) -> list[str]:
    sign = "✗" if change.failed else CHANGES[change.change][0]
    words = [change.summary, *map(moved_text, _left_band(change))]
    first = "" if change.first_difference is None else change.first_difference.words
    command = _code(change.command)
    kind = f"{sign} {kind_text(change)}"
    return [_cell(change.scene), kind, _cell("; ".join(words)), _cell(first), command]


def _left_band(change: SceneChange, level: str = "error") -> list[Quantity]:
    quantities = (*change.metrics, *change.counters)
    return [one for one in quantities if not one.within and one.level == level]


def _failures(results: Results) -> Iterator[_Block]:
    bad = bad_cases(results)
    if not bad:
        return
    header = ["scene", "engine", "what", "why it is asked", "command"]
    rows = [_row(cells) for case in bad for cells in _failure_cells(case)]
    head = (
        "### Not right\n\n`ghostball explain SCENE --engine ENGINE` says where a shot leaves the "
        f"true one.\n\n{_table_head(header)}"
    )
    yield _Block(head, rows, "failure", "`report.md` of the results has them all.")


def _failure_cells(case: CaseRecord) -> Iterator[list[str]]:
    where = [_cell(case.scene), _code(case.label)]
    command = _code(_command(case))
    if why := unfinished_text(case):
        yield [*where, _cell(f"did not finish: {why}"), "", command]
    for check in case.checks:
        if check.passed is False:
            yield [*where, _cell(check.sentence), _cell(check.reason), command]


def _command(case: CaseRecord) -> str:
    """Return what runs a case again, wherever the results came from."""
    return commands.validate(case.scene, case.label, "out/again")


def _matrix(results: Results) -> _Block:
    rows, present = [], []
    for scene in results.scene_names:
        cases = [results.case(scene, label) for label in results.labels]
        present += [verdict_of(case) for case in cases]
        rows.append(_row([_cell(scene), *(_cell(cell_text(case)) for case in cases)]))
    labels = [_code(label) for label in results.labels]
    legend = f"{legend_text(present)}. {NUMBERS_KEY}."
    head = f"### Verdicts\n\n{legend}\n\n{_table_head(['scene', *labels])}"
    return _Block(head, rows, "scene", "`report.md` of the results has them all.")


def _case_lines(results: Results) -> Iterator[tuple[str, str, str]]:
    for case in bad_cases(results):
        again = f"[{_command(case)}]"
        if why := unfinished_text(case):
            yield case.scene, "error", f"{case.label}: did not finish: {why} {again}"
        for check in case.checks:
            if check.passed is False:
                reason = f"({check.reason})"
                yield case.scene, "error", f"{case.label}: {check.sentence} {reason} {again}"
    for case in results.cases:
        if case.outcome == "unavailable":
            yield case.scene, "warning", f"{case.label}: unavailable: {case.reason}"
    if results.state != "complete":
        yield str(results.path), "error", f"the run is not complete: {results.state}"


def _change_lines(regression: Regression) -> Iterator[tuple[str, str, str]]:
    for change in _in_order(regression.scenes):
        again = f"[{change.command}]" if change.command else ""
        if _is_told(change):
            uncompared = change.change in UNCOMPARED
            level = "error" if change.failed or uncompared else "warning"
            yield change.scene, level, f"{kind_text(change)}: {change.summary} {again}"
        if change.failed and change.first_difference is not None:
            yield change.scene, "note", f"first difference: {change.first_difference.words}"
        for asked, level in (
            ("error", "error" if change.failed else "warning"),
            ("warn", "warning"),
        ):
            for quantity in _left_band(change, asked):
                yield change.scene, level, f"{moved_text(quantity)} ({quantity.why})"
    for warning in regression.warnings:
        yield "regression", "warning", warning
    for scene in regression.stale:
        yield scene, "warning", "baseline of a scene that is no more"


def _table_head(header: Sequence[str]) -> str:
    return table_of(header, [])


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _cell(text: str) -> str:
    """Return a text for a cell: one line, not too long, and no HTML."""
    plain = " ".join(text.split())
    if len(plain) > CELL:
        plain = f"{plain[: CELL - 1]}…"
    return one_line(plain.replace("<", "&lt;"))


def _code(text: str) -> str:
    """Return a text for a cell as code, whole: half a command is none."""
    return f"`{one_line(text)}`" if text else ""
