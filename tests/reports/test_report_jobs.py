"""How many processes make a report."""

from ghostball.reports import report, write_report


def test_a_page_of_a_few_cases_without_pictures_takes_no_other_process(small_folder, monkeypatch):
    # To start a process and import what it needs takes as long as some hundred cases.
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
