"""Survival is counted right, and its worst case is the one to show."""

from __future__ import annotations

from pathlib import Path

import pytest

from ghostball.validation.stress.families.tunnelling import DEPTH, SPEED
from ghostball.validation.stress.findings import Finding, StressFolder, StressRun
from ghostball.validation.stress.survival import Survival, all_survival, scene_file, tracked_numbers

SCENE = {"schema": 1, "name": "x", "balls": [{"id": "a", "position": [0.0, 0.0, 0.028575]}]}


def folder(*findings):
    labels = tuple(dict.fromkeys(one.label for one in findings))
    families = tuple(dict.fromkeys(one.family for one in findings))
    run = StressRun("quick", families, labels, {})
    return StressFolder(Path("some where"), run, list(findings))


def found(trial, outcome, severity=0.0, label="pymunk", family="f", **fields):
    faults = ("it broke",) if outcome == "broken" else ()
    return Finding(family, trial, label, outcome, faults, severity, **fields)


def test_outcomes_and_shots_are_counted():
    one = Survival(
        folder(
            found("a", "survived", shots=3, seconds=1.0),
            found("b", "broken", 2.0, shots=5, broken=2, seconds=0.5),
            found("c", "not-representable"),
        ),
        "f",
        "pymunk",
    )
    counted = [one.count(name) for name in ("survived", "broken", "not-representable")]
    assert (counted, one.tried, one.text) == ([1, 1, 1], 2, "1/2")


@pytest.mark.parametrize(
    ("outcome", "text"), [("not-representable", "–"), ("unavailable", "unavailable")]
)
def test_what_nothing_is_known_of_has_no_number(outcome, text):
    assert Survival(folder(found("a", outcome)), "f", "pymunk").text == text


def test_breaks_come_worst_first_and_a_break_is_worse_than_any_close_call():
    there = folder(
        found("close", "survived", 0.99, scene=SCENE),
        found("bad", "broken", 1.0, scene=SCENE),
        found("worse", "broken", 7.0, scene=SCENE),
        found("worst-but-no-scene", "broken", 9.0),
    )
    one = Survival(there, "f", "pymunk")
    assert [case.trial for case in one.of("broken")] == ["worst-but-no-scene", "worse", "bad"]
    assert one.worst is not None
    assert one.worst.trial == "worse"


def test_the_command_names_the_scene_and_the_engine_with_its_settings():
    worst = found("a", "broken", 1.0, label="pymunk:contact_steps=exact,dt=1e-3", scene=SCENE)
    path = scene_file(worst, Path("some where"))
    assert path == Path("some where/worst/f-pymunk_contact_steps=exact,dt=1e-3.toml")
    assert Survival(folder(worst), "f", worst.label).command == (
        f"ghostball run '{path}' --engine pymunk:contact_steps=exact,dt=1e-3"
    )
    assert Survival(folder(found("a", "survived")), "f", "pymunk").command is None


def test_the_other_command_tries_the_trial_again_in_a_folder_of_its_own():
    # Not in the run's: by other code, all that it holds would go.
    there = folder(
        found("a", "survived", 0.5, label="pymunk:contact_steps=exact", scene=SCENE),
        found("b", "broken", 1.0, label="pymunk:contact_steps=exact"),
    )
    one = Survival(there, "f", "pymunk:contact_steps=exact")
    assert one.again == (
        "ghostball stress f/b --engine pymunk:contact_steps=exact --rerun --out 'some where-again'"
    )
    assert Survival(folder(), "f", "pymunk").again is None


def test_what_was_not_judged_counts_for_nothing_and_is_said():
    one = Survival(folder(found("a", "survived"), found("b", "failed")), "f", "pymunk")
    assert (one.tried, one.count("failed"), one.text) == (1, 1, "1/1, 1 not judged")
    assert [failed.trial for failed in one.of("failed")] == ["b"]


def test_each_family_and_engine_that_something_is_known_of_comes_once():
    there = folder(
        found("a", "survived"),
        found("b", "survived"),
        found("a", "survived", label="pybullet"),
        found("a", "survived", family="g"),
    )
    pairs = [(one.family, one.label) for one in all_survival(there)]
    assert pairs == [("f", "pymunk"), ("f", "pybullet"), ("g", "pymunk")]


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
