"""The report shows verdicts and reasons, and a bad folder gives a clear error."""

import pytest

from ghostball.reports import PAGE, report, write_report


def drawn(folder):
    return {path.name for path in (folder / "figures").glob("*")}


def test_pictures_are_those_that_are_asked_for_and_the_page_holds_or_names_them(small_folder):
    seen = []
    page = write_report(small_folder, progress=lambda *part: seen.append(part))
    assert seen == [(1, 1, "part of report.html on scene stop")]
    assert drawn(small_folder) == {"stop-sheet.png"}
    text = page.read_text(encoding="utf-8")
    assert '<a href="figures/stop-sheet.png">' in text
    assert text == write_report(small_folder, figures="svg").read_text(encoding="utf-8")
    assert drawn(small_folder) == {"stop-sheet.png", "stop-sheet.svg"}
    assert text == write_report(small_folder).read_text(encoding="utf-8")
    assert drawn(small_folder) == {"stop-sheet.png"}
    text = write_report(small_folder, figures="none").read_text(encoding="utf-8")
    assert drawn(small_folder) == set()
    assert "stop-sheet" not in text


def test_another_process_draws_the_same(small_folder):
    (small_folder / "figures").mkdir()
    for name in ("gone-sheet.png", "mine.png"):  # an old sheet, a file of the user
        (small_folder / "figures" / name).touch()

    def contents():
        paths = [small_folder / PAGE, *(small_folder / "figures").iterdir()]
        return {path.name: path.read_bytes() for path in paths}

    seen = []
    write_report(small_folder, figures="svg")
    one = contents()
    write_report(small_folder, progress=lambda *part: seen.append(part), jobs=2, figures="svg")
    assert seen[-1][0] == seen[-1][1] == len(seen)
    assert contents() == one
    assert one.keys() == {PAGE, "stop-sheet.png", "stop-sheet.svg", "mine.png"}


def test_a_page_of_a_few_cases_without_pictures_takes_no_other_process(small_folder, monkeypatch):
    # Starting a process takes as long as some hundred cases.
    asked = []
    run_tasks = report.run_tasks

    def watched(tasks, jobs, work):
        asked.append(jobs)
        return run_tasks(tasks, 1, work)

    monkeypatch.setattr(report, "run_tasks", watched)
    for figures in ("none", "png"):
        write_report(small_folder, jobs=2, figures=figures)
    assert asked == [1, 2]
    monkeypatch.setattr(report, "CASES_WORTH_A_PROCESS", 1)
    write_report(small_folder, jobs=2, figures="none")
    assert asked[2] == 2


def test_what_is_cut_off_while_it_is_written_leaves_no_picture(small_folder, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("ghostball.validation.results.files.Path.replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_report(small_folder)
    assert not list((small_folder / "figures").iterdir())


def test_the_repr_of_results_is_one_screen_at_most(results):
    # The repr must not print every case with its arrays.
    said = repr(results)
    assert len(said) < 80 * 24 / 2
    for part in ("complete", f"{len(results.cases)} cases", "ghostball", "1 more"):
        assert part in said
