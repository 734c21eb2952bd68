"""Fails where the page hides what was measured of a scene, or what is to be said of a run."""

import pytest
from stored_records import edit_records

from ghostball.reports.page.scene_numbers import counted_rows, number_heads, number_row, remarks
from ghostball.validation.results.store import Results


@pytest.fixture(scope="module")
def results(module_folder):
    """Three scenes on seven engines."""
    return Results.open(module_folder)


def cases_of(results, scene):
    return [case for case in results.cases if case.scene == scene]


def test_every_engine_that_did_not_run_or_failed_has_its_reason(results):
    said = list(remarks(cases_of(results, "head-on")))
    (failed,) = (one for one in said if one.failed and one.case.label == "paper-discrete")
    assert failed.failed.reason == "a tenth of a ball"
    texts = {(one.case.label, one.text) for one in said}
    assert ("pybullet", "not representable: no table | with legs") in texts
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


def test_what_engines_counted_is_summed_over_the_scenes(module_folder):
    joint = "simultaneous impacts, resolved together"
    pulls = "overlapping balls pulled apart"
    where = [(scene, 3) for scene in ("break-7", "head-on", "stop")]
    assert list(counted_rows(Results.open(module_folder))) == [
        ("ghostball", joint, 2, [("break-7", 2)], 0),
        ("paper-discrete", pulls, 9, where, 0),
    ]
