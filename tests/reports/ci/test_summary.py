"""The summaries for CI services contain all failures, and say if something is left out."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest
from regressions import quantity, regression, unchanged, uncompared, worse

from ghostball.reports.ci.findings import SHOWN, Finding, findings, note, notes
from ghostball.reports.ci.summary import summary_markdown, summary_text
from ghostball.validation.results.store import Results

# Failures as notes for GitHub: one line each, and a count of the rest.


@pytest.fixture
def passed(results):
    """Results without failures."""
    return Results(results.path, [], results.environment)


def test_a_broken_limit_says_how_to_see_it(results):
    found = findings(results, [])
    (one,) = (f for f in found if f.title == "stop fails a limit" and "discrete" in f.message)
    assert one.level == "error"
    assert "rest_error_max must be at most 5 mm, got 30 mm (a tenth of a ball)" in one.message
    assert one.message.endswith("To repeat: ghostball explain stop --engine paper-discrete")
    (lost,) = (f for f in found if f.title == "head-on did not finish")
    assert "newcomer:dt=1e-3: did not finish: division by zero" in lost.message


def test_what_moved_says_by_how_much(passed):
    shown = worse(), unchanged("stop"), unchanged("cut", change="better", head_hash="c" * 64)
    error, warning = findings(passed, [regression(*shown)])
    assert (error.level, error.title) == ("error", "break-7: worse")
    assert "which is missing now" in error.message
    assert error.message.startswith("ghostball: worse, rest error 7 fm -> 3 mm\n")
    assert (warning.level, warning.title) == ("warning", "cut: better")


def test_limits_alone_are_said_once(passed):
    broken = unchanged("stop", failed=True, broken=("energy_rise must be at most 0, got 1",))
    assert findings(passed, [regression(broken)]) == []


def test_missing_baselines_are_one_finding_unless_limits_alone_are_asked(passed):
    many = [uncompared(f"shot-{k}") for k in range(9)]
    (one,) = findings(passed, [regression(*many, outcome="no-baseline")])
    assert (one.level, one.title) == ("error", "no baseline")
    assert "in 9 scenes. Run `ghostball regress`" in one.message
    (few,) = findings(passed, [regression(many[0], outcome="no-baseline")])
    assert "in shot-0. Run" in few.message
    assert findings(passed, [regression(*many, outcome="passed", fail_on="limits")]) == []


def test_a_note_is_one_line_that_ends_no_property_early():
    one = Finding("error", "a", "a: b, c", "100 %\nnext")
    assert notes([one]) == ("::error title=Ghostball%3A a%3A b%2C c::100 %25%0Anext\n")
    assert note("error", "x", "y") == "::error title=Ghostball%3A x::y"


def test_more_than_github_shows_are_counted():
    def some(level, count):
        return [Finding(level, "a", f"{level}-{k}", "x") for k in range(count)]

    lines = notes([*some("error", SHOWN + 3), *some("warning", SHOWN)]).splitlines()
    assert len(lines) == 2 * SHOWN
    assert lines[SHOWN - 1].startswith("::error title=Ghostball%3A 4 more::error-9, error-10")


def test_what_was_not_tried_and_an_unfinished_run_are_said_once(results):
    case = replace(results.cases[0], label="mine", outcome="unavailable", reason="no wheel")
    cases = [replace(case, scene=name) for name in ("stop", "cut")]
    run = Results(results.path, cases, results.environment | {"state": "running"})
    compared = regression(unchanged(), warnings=("slow",))
    found = findings(run, [compared])
    said = [(one.level, one.title, one.message) for one in found]
    assert said == [
        ("error", "incomplete", "the run is incomplete: running"),
        ("warning", "mine is unavailable", "no wheel"),
        ("warning", "comparison with baselines", "slow"),
    ]


# The summary starts with the verdict, counts left out rows, and has a limited length.


def with_cases(results, cases, **environment):
    return Results(results.path, cases, results.environment | environment)


def rows_of(text: str, heading: str) -> list[list[str]]:
    """Return the cells of each row of a section's table; every line of the table must be a row."""
    section = text.partition(f"### {heading}")[2].partition("\n### ")[0]
    lines = [line for line in section.splitlines() if line.startswith("|")]
    rows = [re.split(r"(?<!\\)\|", line)[1:-1] for line in lines]
    assert len({len(row) for row in rows}) <= 1
    return [[cell.strip() for cell in row] for row in rows[2:]]


def test_the_verdict_comes_first(results):
    text = summary_markdown(results, regression(worse(), unchanged()))
    assert text.startswith("## ✗ Ghostball: Failed, baseline check failed\n")
    assert "\n✗ Compared with the accepted baselines, 1 of 2 scenes fails (1 worse): " in text
    assert "9 scenes on 5 engines in 7 configurations: " in text
    order = [text.index(f"### {part}") for part in ("What changed", "Failures", "Verdicts")]
    assert order == sorted(order)


def test_what_changed_comes_with_where_and_how_to_see_it(results):
    (row,) = rows_of(summary_markdown(results, regression(worse(), unchanged())), "What changed")
    assert row[0] == "break-7"
    assert row[1] == "✗ worse"
    assert row[2] == "rest error 7 fm -> 3 mm; rest error 3 mm, was 7 fm"
    assert "which is missing now" in row[3]
    assert row[4] == "`ghostball run break-7`"


def test_what_failed_comes_with_its_limit_its_reason_and_a_command(results):
    rows = rows_of(summary_markdown(results), "Failures")
    assert [
        "stop",
        "`paper-discrete`",
        "rest_error_max must be at most 5 mm, got 30 mm",
        "a tenth of a ball",
        "`ghostball validate stop --engine paper-discrete --out out/again`",
    ] in rows
    assert ["head-on", "`newcomer:dt=1e-3`", "did not finish: division by zero"] in [
        row[:3] for row in rows
    ]


@pytest.mark.parametrize(
    ("change", "kind"),
    [("rounding", "rounding"), ("unchanged", "same result, different work counters")],
)
def test_what_fails_is_counted_once_and_not_as_before(change, kind):
    failing = unchanged("cut", change=change, failed=True, counters=(quantity("roots"),))
    text = summary_markdown(None, regression(failing, unchanged()))
    assert f"1 of 2 scenes fails (1 {kind}): `ghostball regress` fails until" in text
    assert "1 scene without a real change: 1 unchanged." in text
    assert rows_of(text, "What changed")[0][:2] == ["cut", f"✗ {kind}"]


def test_the_summary_stays_below_its_limit_and_counts_what_it_omits(results):
    # 2000 failures, each with a reason of several pages, and as many changes.
    bad = next(case for case in results.cases if case.outcome == "failed")
    cases = [replace(bad, scene=f"scene-{k}", reason="why | <x>\n" * 500) for k in range(2000)]
    many = regression(*(worse(f"scene-{k}", summary="so much\n" * 200) for k in range(2000)))
    text = summary_markdown(with_cases(results, cases, scenes=[]), many)
    assert len(text.encode()) < 2**20  # GitHub's limit
    for heading in ("What changed", "Failures", "Verdicts"):
        shown = len(rows_of(text, heading))  # complete rows
        section = text.partition(f"### {heading}")[2].partition("\n### ")[0]
        left = re.search(r"\*(\d+) more \w+ omitted to", section)
        assert shown + (0 if left is None else int(left[1])) == 2000


LINE = re.compile(r"[^:\n]+: (error|warning|note): .+")


def test_plain_text_is_a_line_for_each_thing(results):
    text = summary_text(results, regression(worse(), uncompared(), warnings=("slow",)))
    lines = text.splitlines()
    assert all(LINE.fullmatch(line) for line in lines)
    assert (
        "stop: error: paper-discrete: rest_error_max must be at most 5 mm, got 30 mm "
        "(a tenth of a ball); To repeat: ghostball explain stop --engine paper-discrete"
    ) in lines
    assert any(
        line.startswith("baselines: error: ghostball can't be compared with a baseline in head-on.")
        for line in lines
    )
    (moved,) = (line for line in lines if line.startswith("break-7: error: ghostball: worse"))
    assert "; roots 10 -> 12; " in moved
    assert "baselines: warning: slow" in lines
    assert [line.split(": ")[0] for line in lines[-2:]] == ["ghostball", "ghostball"]


def test_the_summary_says_how_right_each_engine_is(results):
    # Every class must be counted, and a right engine must look different from a wrong one.
    text = summary_markdown(results)
    table = text.partition("### Scenes by accuracy class")[2].partition("###")[0]
    assert "| engine | exact | nm | µm | mm | cm | wrong collisions | median error |" in table
    assert "| `ghostball` | 5 | 0 | 0 | 0 | 0 | 0 | rounding |" in table
    assert "| `paper-discrete` | 0 | 0 | 0 | 0 | 2 | 7 | 30 mm |" in table
    assert "wrong collisions: collisions that differ from the reference" in table
