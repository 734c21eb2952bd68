"""Fails where the first lines of the page hide a verdict, or that a run isn't whole."""

import pytest
from stored_results import edit_document, edit_records, in_database

from ghostball.reports.page.verdict import verdict_html
from ghostball.validation.results.store import Results


def test_verdicts_are_counted_and_what_is_wrong_is_named_with_its_reason(module_folder):
    html = verdict_html(Results.open(module_folder), None)
    assert (
        "3 scenes on 5 engines in 7 configurations: <strong>8 passed, 6 failed</strong>, "
        "<strong>1 did not finish</strong>, 0 keep their limits" in html
    )
    assert "3 not representable" in html
    assert '<a href="#scene=head-on">head-on</a> on <code>newcomer:dt=1e-3</code>: did not' in html
    assert (
        "<strong><code>paper-discrete</code> fails</strong>: rest_error_max must be &lt;= 0.005 m, "
        "got 0.03 m (a tenth of a ball)" in html
    )
    assert "left unsolved" not in html


def test_an_unsolved_contact_step_is_reported_at_the_top(small_folder):
    edit_records(
        small_folder, lambda text: text.replace('"steps":50', '"unsolved_contact_steps":1')
    )
    html = verdict_html(Results.open(small_folder), None)
    assert "<strong>3 sustained or joint contacts left unsolved.</strong>" in html


def test_a_run_that_was_killed_is_said_to_be(small_folder):
    in_database(small_folder, "DELETE FROM records WHERE id = (SELECT max(id) FROM cases)")
    edit_document(small_folder, "suite", state="running")
    html = verdict_html(Results.open(small_folder), None)
    wanted = "not complete</strong>: it is still running, or was killed; 2 of 3 cases are done."
    assert wanted in html
    assert "1 scene on 2 engines: " in html


@pytest.mark.parametrize(("measured", "said"), [(["energy_rise"], True), (None, False)])
def test_metrics_that_were_not_measured_are_said(small_folder, measured, said):
    if measured is not None:
        edit_document(small_folder, "suite", metrics=measured)
    html = verdict_html(Results.open(small_folder), None)
    assert ("Only some metrics were measured</strong>: <code>energy_rise</code>." in html) is said
