"""The sections of the page show all verdicts, scenes, numbers and reasons."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from page_texts import folded, page_of, read, section
from stored_records import change_motion, edit_document, edit_records, in_database
from written_results import write_results

from ghostball.reports.page import scene_part
from ghostball.reports.page.scene_numbers import counted_rows, number_heads, number_row, remarks
from ghostball.reports.page.stress import stress_html
from ghostball.reports.page.verdict import engines_html, verdict_html
from ghostball.reports.shots import load_shot
from ghostball.validation.baselines import (
    FirstDifference,
    Regression,
    SceneChange,
    ValueChange,
    save_regressions,
)
from ghostball.validation.results.store import Results
from ghostball.validation.stress import StressSize, chosen_shots, run_stress

# Sections over all scenes show verdicts, scenes, reasons, and what is missing.


def test_verdicts_are_counted_and_what_is_wrong_is_named_with_its_reason(three_folder):
    html = verdict_html(Results.open(three_folder), None)
    assert (
        "3 scenes on 5 engines in 7 configurations: 8 passed, 6 failed, 1 did not finish, "
        "3 unsupported" in html
    )
    assert '<a href="#scene=head-on">head-on</a> on <code>newcomer:dt=1e-3</code>: did not' in html
    assert (
        "<strong><code>paper-discrete</code> fails</strong>: rest_error_max must be at most 5 mm, "
        "got 30 mm (a tenth of a ball)" in html
    )
    assert "not solved" not in html


def test_an_unsolved_contact_step_is_reported_at_the_top(small_folder):
    edit_records(
        small_folder, lambda text: text.replace('"steps":50', '"unsolved_contact_steps":1')
    )
    html = verdict_html(Results.open(small_folder), None)
    assert "<strong>3 resting or simultaneous contacts not solved.</strong>" in html


def test_a_run_that_was_killed_is_said_to_be(small_folder):
    in_database(small_folder, "DELETE FROM records WHERE id = (SELECT max(id) FROM cases)")
    edit_document(small_folder, "suite", state="running")
    html = verdict_html(Results.open(small_folder), None)
    wanted = "incomplete (still running, or killed): 2 of 3 cases are done."
    assert wanted in html
    assert "1 scene on 2 engines: " in html


@pytest.mark.parametrize(("measured", "said"), [(["energy_rise"], True), (None, False)])
def test_metrics_that_were_not_measured_are_said(small_folder, measured, said):
    if measured is not None:
        edit_document(small_folder, "suite", metrics=measured)
    html = verdict_html(Results.open(small_folder), None)
    assert ("Only some metrics were measured</strong>: <code>energy_rise</code>." in html) is said


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
    cell = (
        f' class="acc-cm"><a href="#scene=stop" data-view="{link}">90 mm&nbsp;<span class="mark">✗'
    )
    assert f'{cell}</span><span class="why">' in text
    assert (
        "stop on pymunk:config=naive: centimetres: the largest position error of a ball is 90 mm, "
        "compared with the reference; failed: rest_error_max must be at most 5 mm, got 90 mm"
        in text
    )
    assert "<code>pybullet</code> unsupported: no table | with legs" in text
    assert "did not finish: division by zero" in text


def test_a_limit_stands_below_a_large_error_that_passed(html):
    cells = re.findall(r"<td[^>]*><a [^>]*>(.*?)<span class=\"why\">", section(html, "matrix"))
    passed = [cell for cell in cells if " mm" in cell and "✓" in cell]
    assert passed
    assert all(
        re.search(r'<span class="allowed">within the limit of [\d.]+ .?m</span>', one)
        for one in passed
    )
    failed = [cell for cell in cells if "✗" in cell]
    assert not any("allowed" in cell for cell in failed)


def test_three_comparisons_of_the_scene_that_differs_most_stand_side_by_side(html, three_folder):
    text = section(html, "comparison")
    results = Results.open(three_folder)
    most = max(
        results.scene_names,
        key=lambda name: scene_part(load_shot(results, name)).comparison.difference,
    )
    assert f'<a href="#scene={most}">' in text
    assert re.findall("<h3>(.*?)</h3>", text) == ["Rest positions", "Collisions", "Energy"]
    ran = [case for case in results.cases if case.scene == most and case.outcome == "ran"]
    assert text.count('<tr><th scope="row">') == len(ran)
    drawn = re.findall(r'<text class="marker" x="([\d.-]+)" y="([\d.-]+)"', text)
    balls = len(ran[0].load_scene().balls)
    assert text.count('<circle class="ring"') == balls
    assert len(drawn) >= balls * len(ran)


def test_an_engine_alone_is_compared_with_nothing(tmp_path):
    folder = write_results(tmp_path / "alone", ["stop"], ["pymunk"])
    assert 'id="comparison"' not in page_of(folder)


def test_every_failure_is_explained_with_its_command_and_what_it_must_give(html):
    text = section(html, "failures")
    assert text.count('<details class="failure"') == 7
    assert "<dt>Expected<dd>at most 5 mm" in text
    assert "<dt>Found<dd>30 mm (0.03 m)" in text
    assert "<code>newcomer:dt=1e-3</code>: did not finish</summary>" in text
    assert "<dt>Found<dd>division by zero" in text
    assert "ghostball explain stop --engine paper-discrete" in text
    assert "ghostball run head-on --engine newcomer:dt=1e-3" in text
    assert re.search(r'<code>hash</code> [^<]* <code class="hash">[0-9a-f]{64}</code>', text)
    assert "<code>cue</code> at (1.47, 0.8) m" in text


def test_what_is_missing_says_so_and_how_to_get_it(html):
    for name, words in {
        "closed-forms": "that rounding the scene’s numbers once would cause",
        "cost": "one timing each",
        "horizons": "are predictable to their end",
        "energy": "No exact motion is stored",
        "hashes": "There is no baseline to compare them with",
        "timing": "One timing each",
    }.items():
        assert words in folded(html, name), name


# A changed scene is shown with baseline and new result.


EVIL = "</script><script>alert(1)</script><img src=x onerror=alert(1)>"


def regression(**changes):
    fields = {
        "scene": "stop",
        "title": "One ball rolls to rest",
        "change": "worse",
        "failed": True,
        "summary": f"the cue ball ends 3 mm farther {EVIL}",
        "first_difference": FirstDifference(
            index=4, before_horizon=True, words="cue hits 1 no more"
        ),
        "metrics": (ValueChange(name="rest_error_max", unit="m", base=1e-16, head=3e-3),),
        "counters": (ValueChange(name="events", unit="1", base=9, head=None),),
        "base_hash": "a" * 64,
        "head_hash": "b" * 64,
        "rest_base": ((1.5, 0.8, 0.028575),),
        "rest_head": ((1.503, 0.8, 0.028575),),
        "command": "ghostball regress stop",
    }
    change = SceneChange(**(fields | changes))
    return Regression(head={}, outcome="failed", scenes=(change,))


def test_what_changed_is_shown_with_both_sides(small_folder):
    save_regressions([regression()], small_folder)
    html = page_of(small_folder)
    text = section(html, "verdict")
    assert "✗ baseline check failed" in text
    assert "worse: farther from the reference result: 1, <strong>fails</strong>" in text
    assert "(1.5, 0.8) m<td>(1.503, 0.8) m<td>3 mm" in text
    assert "<code>rest_error_max</code><td>0.1 fm<td>3 mm<td>+3 mm" in text
    assert "<code>events</code><td>9<td>–<td>–" in text
    assert "cue hits 1 no more" in text
    assert '<circle class="head" cx="1.503" cy="0.8" r="0.028575"/>' in text
    assert '<circle class="base" cx="1.5" cy="0.8" r="0.028575"/>' in text
    assert "≠ not equal" in folded(html, "hashes")
    assert read(html).wrong == []
    assert "<img" not in html


# Every scene has a complete part of the page.


def test_every_scene_has_its_section_and_its_data(html):
    for name in ("stop", "head-on", "break-7"):
        assert f'<section class="scene" id="scene={name}"' in html
        data = re.search(
            f'<script type="application/json" id="replay-{name}">(.*?)</script>', html, re.DOTALL
        )
        assert json.loads(data[1])["scene"] == name
        assert f'data-replay="replay-{name}"' in html


def test_a_limit_is_said_once_with_all_that_it_judges(html):
    start = html.index('id="scene=stop"')
    text = html[start : html.index("</section>", start)]
    assert text.count("a tenth of a ball") == 1 + 2  # in the table of limits, and with each failure
    assert "<li>✓ <code>pymunk</code> 2 mm</li>" in text
    assert "<li>✗ <code>paper-discrete</code> 30 mm</li>" in text


@pytest.mark.parametrize("label", ["ghostball", "pymunk"])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_an_engine_that_blew_up_does_not_break_the_page(small_folder, label, bad):
    def blown_up(values):
        return np.where(np.arange(len(values)) < len(values) // 2, values.T, bad).T

    names = ("positions", "velocities", "angular_velocities")
    energies = ("energy_translation", "energy_rotation", "energy_height")
    change_motion(small_folder, "stop", label, **dict.fromkeys(names + energies, blown_up))
    # Only the scene's part: the figures of the report have their own tests.
    html = scene_part(load_shot(Results.open(small_folder), "stop")).html
    assert "nan" not in "".join(re.findall(r'<path[^>]* d="([^"]*)"', html))
    assert "Total energy against time" in html


# The page shows all measured values of a scene, and all remarks about a run.


def cases_of(results, scene):
    return [case for case in results.cases if case.scene == scene]


def test_every_engine_that_did_not_run_or_failed_has_its_reason(results):
    said = list(remarks(cases_of(results, "head-on")))
    (failed,) = (one for one in said if one.failed and one.case.label == "paper-discrete")
    assert failed.failed.reason == "a tenth of a ball"
    texts = {(one.case.label, one.text) for one in said}
    assert ("pybullet", "unsupported: no table | with legs") in texts
    assert ("newcomer:dt=1e-3", "did not finish: division by zero") in texts


def test_what_a_run_counted_is_shown(results):
    joint = "simultaneous impacts, resolved together"
    said = {(one.case.label, one.text) for one in remarks(cases_of(results, "break-7"))}
    assert ("ghostball", f"counted 2 {joint}") in said


def test_nothing_is_called_rest_where_nothing_rests(small_folder):
    edit_records(small_folder, lambda text: text.replace('"status":"rest"', '"status":"t-max"'))
    heads = number_heads(Results.open(small_folder).cases)
    assert {"end error, rms", "end time [s]"} <= set(heads)


def test_a_row_has_a_number_for_each_heading(results):
    cases = cases_of(results, "stop")
    assert {len(number_row(case)) for case in cases} == {len(number_heads(cases))}
    by = {case.label: number_row(case) for case in cases}
    assert by["paper-discrete"][:2] == ["30 mm", "cue"]


def test_what_engines_counted_is_summed_over_the_scenes(three_folder):
    joint = "simultaneous impacts, resolved together"
    pulls = "overlapping balls pulled apart"
    where = [(scene, 3) for scene in ("break-7", "head-on", "stop")]
    assert list(counted_rows(Results.open(three_folder))) == [
        ("ghostball", joint, 2, [("break-7", 2)], 0),
        ("paper-discrete", pulls, 9, where, 0),
    ]


# The page shows the right numbers of generated shots.


COARSE = "pymunk:dt=0.05"
SHOTS = ["grazing/rolling-*-1e-0[14]", "tunnelling/speed-*-depth-0.1-phase-0"]


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    """Return the section about a run of a right and a coarse engine, without markup."""
    folder = tmp_path_factory.mktemp("out")
    run_stress(chosen_shots(StressSize(), SHOTS), ["ghostball", COARSE], folder / "stress")
    html = str(stress_html(Results(folder, [], {})))
    return " ".join(re.sub(r"<[^>]*>", " ", html.replace("<wbr>", "")).split())


def test_the_stress_section_has_every_count_failure_and_command(shown):
    assert "10 shots on 2 engines" in shown
    assert "incomplete" not in shown
    assert re.search(r"Grazing hits and near misses 4/4 3/4", shown)
    assert "collision_count must be exactly 1, got 0" in shown
    assert f"ghostball stress grazing/rolling-hit-1e-04 -e {COARSE}" in shown


def test_the_stress_section_shows_where_each_engine_begins_to_fail(shown):
    assert re.search(r"depth \[diameters\] 0.0001, 0.1 never ≤ 0.0001", shown)
    assert re.search(r"speed \[m/s\] 2, 160 never always", shown)


def test_results_without_generated_shots_have_no_section(tmp_path):
    assert stress_html(Results(tmp_path, [], {})) == ""
