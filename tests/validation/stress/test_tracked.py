"""The numbers by which engines are tracked, from findings made by hand."""

from ghostball.validation.stress.families.tunnelling import DEPTH, SPEED
from ghostball.validation.stress.findings import Finding, StressFolder, StressRun
from ghostball.validation.stress.survival import tracked_numbers


def folder_of(tmp_path, *findings):
    labels = tuple(dict.fromkeys(one.label for one in findings))
    return StressFolder(tmp_path, StressRun("full", ("any",), labels, {}), list(findings))


def finding(label, trial="a", **values):
    return Finding("any", trial, label, "survived", values=values)


def cell(label, speed=SPEED, largest=1e-3, missed=0):
    ladder = [{"dt": 1e-3, "missed": 0}, {"dt": 1e-2, "missed": missed}]
    return finding(label, speed=speed, depth=DEPTH, step=1e-3, largest_step=largest, ladder=ladder)


def test_one_shot_tells_the_largest_step(tmp_path):
    folder = folder_of(
        tmp_path, cell("one", speed=10.0, largest=1e-4), cell("one", missed=2), cell("two")
    )
    one, two = tracked_numbers(folder)
    assert (one["own_step"], one["largest_step_without_a_miss"]) == (1e-3, 1e-3)
    assert (one["larger_steps_miss"], two["larger_steps_miss"]) == (True, False)


def test_an_engine_of_which_nothing_is_known_has_no_row(tmp_path):
    assert tracked_numbers(folder_of(tmp_path, finding("one"))) == []
