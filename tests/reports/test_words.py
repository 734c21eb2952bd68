"""Words and numbers are the same in every report."""

from dataclasses import replace

from likenesses import likeness

from ghostball.reports.words import likeness_cell, many, reused_text, run_time_text
from ghostball.validation.results.store import Results


def test_one_is_no_plural():
    assert [many(count, "case") for count in (0, 1, 2)] == ["0 cases", "1 case", "2 cases"]


def test_what_an_earlier_run_measured_is_said_with_its_dates(small_folder):
    results = Results.open(small_folder)
    assert reused_text(results) == ""
    first, *rest = results.cases
    first = replace(first, reused=True, measured="2026-01-02T03:04:05")
    shown = reused_text(Results(results.path, [first, *rest], results.environment))
    assert "1 of 3 cases reused from an earlier run, since it was unchanged" in shown
    assert "measured on 2026-01-02" in shown
    assert run_time_text(first, dated=True).endswith(" (2026-01-02)")
    assert "(" not in run_time_text(first, dated=False)
    assert "(" not in run_time_text(replace(rest[0], measured=""), dated=True)


def test_an_engine_beside_real_tables_is_so_many_errors_off_or_lacks_it():
    rebound, rolling = likeness("ghostball", rebound=-3.0, rolling="it rolls none").families
    assert likeness_cell(rebound) == "3.0 (3.0)"
    assert likeness_cell(rolling) == "–"
    plain = rebound.model_copy(update={"grades": False, "unit": "degrees"})
    assert likeness_cell(plain).endswith("°")
