"""If a part of a report can't be made, the rest is written, and the report names the part."""

import pickle

import pytest
from pool_tasks import crash_in_one_scene

from ghostball.model import GhostballError
from ghostball.reports import PAGE, IncompleteReportError, report, style, write_report
from ghostball.reports.failed_parts import NAMED, FailedPart, attempt, failed_text
from ghostball.reports.page import page


def draw_something(_results):
    return style.new_figure(1.0, 1.0)


def fail(*_, **__):
    raise ZeroDivisionError("no <b>balls</b>")


SAID = "ZeroDivisionError: no &lt;b&gt;balls&lt;/b&gt;"


def written(folder, **options):
    """Return the failed parts of a report, and its page."""
    with pytest.raises(IncompleteReportError) as caught:
        write_report(folder, **options)
    assert caught.value.report == folder / PAGE
    page = (folder / PAGE).read_text(encoding="utf-8")
    return [one.part for one in caught.value.failed], page


# Heading of each part of the page, by the function that makes the part.
PARTS = {
    "verdict_html": "Result and changes",
    "changes_html": "Result and changes",
    "changed_html": "Result and changes",
    "matrix_html": "Engines by scene",
    "failures_html": "Failures explained",
    "cost_html": "Run time against error",
    "closed_forms_html": "Errors in closed-form scenes, in units of rounding",
    "horizons_html": "Predictability horizons",
    "ensembles_html": "Ensembles: rest positions from perturbed initial states",
    "ledgers_html": "Energy losses",
    "hashes_html": "Determinism",
    "timing_html": "Run times",
    "stress_html": "Generated shots",
    "truth_html": "How results are judged",
    "environment_html": "Environment",
}


def test_each_section_costs_itself_alone(small_folder, monkeypatch):
    write_report(small_folder, figures="none")
    whole = (small_folder / PAGE).read_text(encoding="utf-8")
    for name in PARTS:
        monkeypatch.setattr(page, name, fail)
    failed, html = written(small_folder, figures="none")
    assert failed == [f'section "{heading}" of report.html' for heading in PARTS.values()]
    assert "<b>" not in html
    for heading in PARTS.values():
        assert (
            f"The section &#34;{heading}&#34; of report.html could not be written: {SAID}" in html
        )
    assert html.count("Please report it") == len(PARTS)
    for kept in ('<section class="scene"', 'class="nav-verdict', 'data-replay="replay-stop"'):
        assert kept in html
        assert kept in whole
    missing = f"<strong>This report is incomplete</strong>: {len(PARTS)} parts of it could not"
    assert missing in html


def unless_stop(real, name_of):
    """Return a function that fails only in the scene "stop"."""
    return lambda *given: fail() if name_of(*given) == "stop" else real(*given)


@pytest.mark.parametrize(
    ("part", "name_of"),
    [("scene_part", lambda shot, *_: shot.scene.name), ("load_shot", lambda _, name: name)],
)
def test_a_scene_costs_itself_alone(three_folder, monkeypatch, part, name_of):
    monkeypatch.setattr(report, part, unless_stop(getattr(report, part), name_of))
    failed, html = written(three_folder, figures="none")
    assert failed == ["part of report.html on scene stop"]
    start = html.index('id="scene=stop"')
    assert SAID in html[start : html.index("</section>", start)]
    assert html.count(SAID) == 3  # also below its traceback, and at the top
    for kept in ('data-replay="replay-head-on"', '<section id="failures"', 'href="#scene=stop"'):
        assert kept in html
    assert html.count('<section class="scene"') == 3


def test_a_figure_costs_itself_alone(three_folder, monkeypatch):
    name_of = lambda shot: shot.scene.name  # noqa: E731
    monkeypatch.setattr(report, "draw_sheet", unless_stop(report.draw_sheet, name_of))
    failed, html = written(three_folder)
    assert failed == ["figure stop-sheet"]
    assert "stop-sheet.png" not in html
    assert "head-on-sheet.png" in html
    assert f"figure stop-sheet ({SAID})" in html
    assert html.count('<section class="scene"') == 3


def test_a_process_that_crashes_costs_its_part_alone(three_folder, monkeypatch):
    monkeypatch.setattr(report, "_make", crash_in_one_scene)
    monkeypatch.setattr(report, "CASES_WORTH_A_PROCESS", 1)
    failed, html = written(three_folder, jobs=2, figures="none")
    assert failed == ["part of report.html on scene stop"]
    assert "its process crashed (exit code 7)" in html
    assert 'data-replay="replay-head-on"' in html


def test_a_fault_of_ghostball_is_kept_and_what_the_user_can_mend_is_raised():
    def raising(error):
        raise error

    failed = []
    with pytest.raises(GhostballError):
        attempt("page", lambda: raising(GhostballError("damaged")), failed)
    assert failed == []
    missing = FileNotFoundError(2, "No such file", "page.css")
    assert attempt("page", lambda: raising(missing), failed) is None
    assert [one.part for one in failed] == ["page"]


def test_a_disk_that_is_full_is_no_fault_of_a_figure(small_folder, monkeypatch):
    def save(figure, path, *_, **__):
        raise OSError(28, "No space left on device", str(path))

    monkeypatch.setattr(report, "draw_sheet", draw_something)
    monkeypatch.setattr(report.style, "save_figure", save)
    with pytest.raises(GhostballError, match="stop-sheet: can't write the report: No space left"):
        write_report(small_folder)


def test_many_parts_are_counted_not_all_named():
    failed = [FailedPart(f"part {k}", "E: e", "") for k in range(NAMED + 3)]
    text = failed_text(failed)
    assert text.startswith(f"{NAMED + 3} parts of it could not be written: part 0 (E: e), part 1")
    assert text.endswith("and 3 more")


def test_the_error_says_what_was_written_and_crosses_processes(tmp_path):
    error = IncompleteReportError(tmp_path / "report.html", [FailedPart("figure a", "E: e", "")])
    again = pickle.loads(pickle.dumps(error))
    assert str(again) == str(error)
    assert "report.html: written, but 1 part of it could not be written: figure a (E: e)" in str(
        error
    )
