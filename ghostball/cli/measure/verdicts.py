"""Verdicts of a run for the terminal: scenes by engine, totals of each engine, failures."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from rich.console import Console, Group, RenderableType
from rich.markup import escape
from rich.measure import Measurement
from rich.table import Table

from ghostball.cli.shared.tables import table_of
from ghostball.reports import style
from ghostball.reports.accuracy import (
    CLASSES,
    MARKS,
    MEANINGS,
    cell_text,
    kinds_of,
    tally,
    wrong_text,
)
from ghostball.reports.outcome import failures
from ghostball.reports.shared_tables import (
    COMPARISON_HEADS,
    COMPARISON_KEY,
    ENSEMBLE_HEADS,
    ENSEMBLE_KEY,
    comparison_cells,
    ensemble_remarks,
    ensemble_rows,
)
from ghostball.reports.words import AGREEMENT_KEY, agreement_cell, many
from ghostball.validation.checks.verdict import Verdict, unfinished_text, verdict_of
from ghostball.validation.measured.table_agreement import TableAgreement
from ghostball.validation.results.store import CaseRecord, Results
from ghostball.validation.suite.ensemble import PerturbationSize
from ghostball.validation.suite.suite import SuiteResult

COLOURS = {
    Verdict.PASS: "green",
    Verdict.LIMITS_HOLD: "yellow",
    Verdict.FAIL: "bold red",
    Verdict.CRASHED: "bold red",
    Verdict.UNAVAILABLE: "yellow",
}
FAILURES_SHOWN = 20
"""Largest number of failure lines, so that the tables stay on the screen."""

UNLIMITED = 100_000
"""Console width [columns] at which the natural width of a table is measured."""

_VERDICTS = {mark: verdict for verdict, mark in MARKS.items()}


def verdict_tables(results: Results, console: Console) -> RenderableType:
    """Return the classes by scene (if they fit into `console`), the engines, and the failures."""
    parts: list[RenderableType] = []
    matrix = _matrix(results)
    unlimited = console.options.update_width(UNLIMITED)
    if Measurement.get(console, unlimited, matrix).maximum <= console.width:
        parts.append(matrix)
    engines = _engines(results)
    if Measurement.get(console, unlimited, engines).maximum > console.width:
        engines = _engines(results, broken=True)
    # In a narrow window the lines are wrapped: cut cells would be useless.
    engines.width = Measurement.get(console, unlimited, engines).maximum
    return Group(*parts, engines, _key(results), *failure_lines(results.cases))


def _key(results: Results) -> str:
    """Return the meaning of each accuracy class and mark in the results."""
    classes = [f"{CLASSES[k].short}: {CLASSES[k].meaning}" for k in kinds_of(results.cases)]
    if any(tally(results, label).compared_with for label in results.labels):
        classes.append("reference: used as the reference for the other engines")
    seen = {verdict_of(case) for case in results.cases}
    marks = [f"{MARKS[one]} {MEANINGS[one]}" for one in MARKS if one in seen]
    if seen & {Verdict.NOT_REPRESENTABLE, Verdict.UNAVAILABLE}:
        marks.append("– unsupported, or engine unavailable")
    lines = ["; ".join(classes), "; ".join(marks)]
    return "".join(f"[dim]{line}.[/]\n" for line in lines if line)


def details_table(results: Results) -> RenderableType:
    """Return rest positions, collisions and energy compared with the reference, by case."""
    heads = ("scene", "engine", *map(_stacked, COMPARISON_HEADS))
    rows = (
        (escape(case.scene), escape(case.label), *map(escape, cells))
        for case in _by_scene(results)
        if (cells := comparison_cells(case))
    )
    return Group(
        table_of(heads, rows, right=heads[2:], whole=heads), f"[dim]{escape(COMPARISON_KEY)}[/]\n"
    )


def _by_scene(results: Results) -> Iterable[CaseRecord]:
    pairs = ((scene, label) for scene in results.scene_names for label in results.labels)
    return filter(None, (results.case(*pair) for pair in pairs))


def ensemble_table(results: Results, size: PerturbationSize) -> RenderableType:
    """Return the statistical verdicts on ensembles; `size` is the largest perturbation."""
    rows = (tuple(map(escape, row)) for row in ensemble_rows(results))
    table = table_of(ENSEMBLE_HEADS, rows)
    key = f"[dim]Initial states perturbed by at most {escape(str(size))}. {escape(ENSEMBLE_KEY)}[/]"
    return Group(table, key, *map(escape, ensemble_remarks(results)))


def colour_of(case: CaseRecord) -> str:
    """Return the style for the verdict on a case."""
    return COLOURS.get(verdict_of(case), "default")


def headline(outcome: SuiteResult, seconds: float) -> str:
    """Return the result of a run in one line: counts of checks and cases, and the time."""
    counts = outcome.counts
    parts = [f"{counts.checks_passed} checks passed", f"{counts.checks_failed} failed"]
    if counts.checks_reference:
        parts.append(f"{counts.checks_reference} only compare Ghostball's engine with itself")
    if counts.checks_left_out:
        parts.append(f"{counts.checks_left_out} left out by --metric")
    if counts.unfinished:
        parts.append(f"{many(counts.unfinished, 'case')} did not finish")
    if counts.unavailable:
        parts.append(f"{many(counts.unavailable, 'case')} not run: engine unavailable")
    colour = "green" if outcome.exit_status == 0 else "bold red"
    wrong = wrong_text(outcome.cases)
    if wrong and outcome.exit_status == 0:
        colour = "yellow"
    line = f"[{colour}]{', '.join(parts)}[/] in {seconds:.0f} s"
    return f"{line}; {wrong}" if wrong else line


def _matrix(results: Results) -> Table:
    engines = [style.engine_name(label).replace(", ", "\n") for label in results.labels]
    rows = (
        (scene, *(_cell(results.case(scene, label)) for label in results.labels))
        for scene in results.scene_names
    )
    return table_of(("scene", *engines), rows, whole=("scene", *engines))


def _cell(case: CaseRecord | None) -> str:
    if case is None:
        return ""
    found = case.accuracy
    colour = "default" if found is None else CLASSES[found.kind].terminal
    text = escape(cell_text(case))
    for mark in MARKS.values():
        text = text.replace(mark, f"[/][{COLOURS[_VERDICTS[mark]]}]{mark}")
    return f"[{colour}]{text}[/]"


def _engines(results: Results, *, broken: bool = False) -> Table:
    kinds = kinds_of(results.cases)
    heads = [f"[{CLASSES[k].terminal}]{_stacked(CLASSES[k].short)}[/]" for k in kinds]
    found = [tally(results, label) for label in results.labels]
    unable, crashed = any(one.unable for one in found), any(one.crashed for one in found)
    own = any(one.compared_with for one in found)
    heads += ["reference"] * own + ["not\nrun"] * unable + ["did not\nfinish"] * crashed
    heads += [
        "median\nerror",
        "median\ntime",
        *(MARKS[one] for one in (Verdict.PASS, Verdict.FAIL)),
    ]
    rows = []
    for one in found:
        rows.append(
            (
                escape(_broken(one.label) if broken else one.label),
                *(_count(one.counts.get(kind, 0), CLASSES[kind].terminal) for kind in kinds),
                *([_count(one.compared_with, "default")] * own),
                *([str(one.unable)] * unable),
                *([_alarming(one.crashed)] * crashed),
                one.typical_text,
                style.format_time(one.seconds),
                str(one.expected),
                _alarming(one.worse),
            )
        )
    return table_of(("engine", *heads), rows, right=heads, whole=("engine", *heads))


def _broken(label: str) -> str:
    """Return an engine's label on several lines: its name, then a line for each setting."""
    family, settings = style.split_label(label)
    return "\n  ".join([family, *filter(None, settings.split(","))])


def _stacked(heading: str) -> str:
    return heading.replace(" ", "\n")


def _count(count: int, colour: str) -> str:
    return f"[{colour}]{count}[/]" if count else "[dim]·[/]"


def _alarming(count: int) -> str:
    return f"[bold red]{count}[/]" if count else "0"


def failure_lines(cases: Iterable[CaseRecord]) -> Sequence[str]:
    """Return a line for each failed limit, and for each case that did not finish."""
    lines = []
    for case, check, words, _ in failures(cases):
        where = escape(f"{case.scene} on {case.label}")
        if check is None:
            why = escape(f"{unfinished_text(case)}{_raised_at(case)}")
            lines.append(f"[bold red]did not finish[/] {where}: {why}")
        else:
            lines.append(f"[bold red]failed[/]  {where}: {escape(words)}")
    more = len(lines) - FAILURES_SHOWN
    return [*lines[:FAILURES_SHOWN], f"... and {more} more, in the report"] if more > 0 else lines


def _raised_at(case: CaseRecord) -> str:
    """Return file and line where an engine raised its exception; "" if they are unknown."""
    places = re.findall(r'File "([^"]+)", line (\d+)', case.traceback)
    own = [one for one in places if not {"ghostball", "site-packages"} & {*Path(one[0]).parts}]
    file, line = (own or places or [("", "")])[-1]
    return f" ({Path(file).name}:{line})" if file else ""


def agreement_table(found: Sequence[TableAgreement]) -> RenderableType:
    """Return the difference of each engine from measurements on real tables.

    It is in standard errors if the error of the measurements is known, else in their unit.
    """
    return Group(
        *_agreement_tables(
            found,
            "Difference from measurements on real tables: typical (largest)",
            f"[dim]{AGREEMENT_KEY}[/]\n",
            grades=True,
        ),
        *_agreement_tables(
            found, "Typical difference from measurements that grade no engine", grades=False
        ),
    )


def _agreement_tables(
    found: Sequence[TableAgreement], title: str, key: str = "", *, grades: bool
) -> Iterator[RenderableType]:
    """Yield the title, the table and the key of families of measurements.

    `grades`: whether the families grade engines.
    """
    chosen = [(one, [f for f in one.families if f.grades is grades]) for one in found]
    rows = [
        (escape(one.label), *map(agreement_cell, families))
        for one, families in chosen
        if any(not family.lacks for family in families)
    ]
    if rows:
        heads = ("engine", *(family.short for family in chosen[0][1]))
        yield title
        yield table_of(heads, rows)
        yield key
