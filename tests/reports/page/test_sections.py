"""Fails where a section of the page hides a verdict, a scene, a reason, or what is missing."""

import re

import pytest
from page_texts import folded, section
from stored_records import edit_document, edit_records, in_database

from ghostball.reports.page.verdict import engines_html, verdict_html
from ghostball.validation.results.store import Results


def test_verdicts_are_counted_and_what_is_wrong_is_named_with_its_reason(module_folder):
    html = verdict_html(Results.open(module_folder), None)
    assert (
        "3 scenes on 5 engines in 7 configurations: 8 passed, 6 failed, 1 did not finish, "
        "3 not representable" in html
    )
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
    wanted = "not complete (still running, or killed): 2 of 3 cases are done."
    assert wanted in html
    assert "1 scene on 2 engines: " in html


@pytest.mark.parametrize(("measured", "said"), [(["energy_rise"], True), (None, False)])
def test_metrics_that_were_not_measured_are_said(small_folder, measured, said):
    if measured is not None:
        edit_document(small_folder, "suite", metrics=measured)
    html = verdict_html(Results.open(small_folder), None)
    assert ("Only some metrics were measured</strong>: <code>energy_rise</code>." in html) is said


@pytest.fixture(scope="module")
def results(results_folder):
    return Results.open(results_folder)


def test_every_scene_of_an_engine_is_in_its_bar(results):
    html = str(engines_html(results))
    rows = re.findall(
        r'<tr><th scope="row">(.*?)<td class="bars"[^>]*>(.*?)</div>', html, re.DOTALL
    )
    assert len(rows) == len(results.labels)
    for label, (_, bar) in zip(results.labels, rows, strict=True):
        assert sum(map(int, re.findall(r"flex-grow:(\d+)", bar))) == len(results.scene_names), label


def test_the_matrix_says_why_without_colour_and_without_a_pointer(html):
    text = section(html, "matrix")
    link = "#scene=stop&amp;engine=ghostball&amp;engine=pymunk%3Aconfig%3Dnaive"
    cell = f' class="acc-cm"><a href="#scene=stop" data-view="{link}">90 mm <span class="mark">✗'
    assert f'{cell}</span><span class="why">' in text
    assert (
        "stop on pymunk:config=naive: centimetres: the farthest ball is 90 mm from where it "
        "should be; worse than its limits: rest_error_max breaks its limit" in text
    )
    assert "<code>pybullet</code> not representable: no table | with legs" in text
    assert "did not finish: division by zero" in text


def test_every_failure_is_explained_with_its_command_and_what_it_must_give(html):
    text = section(html, "failures")
    assert text.count('<details class="failure"') == 7
    assert "<dt>Expected<dd>at most 5 mm" in text
    assert "<dt>Found<dd>30 mm (0.03 m)" in text
    assert "ghostball explain stop --engine paper-discrete" in text
    assert "ghostball run head-on --engine newcomer:dt=1e-3" in text
    assert re.search(r'<code>hash</code> [^<]* <code class="hash">[0-9a-f]{64}</code>', text)
    assert "<code>cue</code> at (1.47, 0.8) m" in text


def test_what_is_missing_says_so_and_how_to_get_it(html):
    for name, words in {
        "closed-forms": "is what rounding the scene’s numbers once would cause",
        "cost": "one sample of its run time each",
        "horizons": "can be predicted to their end",
        "energy": "No motion of an engine that records it exactly is stored",
        "hashes": "No comparison was made",
        "timing": "One sample each",
    }.items():
        assert words in folded(html, name), name
