"""What ensembles say: differences are found, none where there is none, and the check can fail."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ghostball.validation.ensembles.run as run_module
from ghostball.engine import Ball, Scene
from ghostball.validation.ensembles import (
    QUANTITIES,
    Ensembles,
    Size,
    compare,
    perturb,
    run_ensembles,
)
from ghostball.validation.ensembles.compare import Compared, permutations_for
from ghostball.validation.scenes.library import find_scene

COUNT = 20


def compared(folder: Path, scenes, labels, count: int = COUNT, **more) -> Compared:
    run_ensembles(scenes, labels, folder, count, **more)
    ensembles = Ensembles.load(folder)
    assert ensembles is not None
    return compare(ensembles)


def test_a_shifted_ensemble_is_detected_in_what_is_shifted_alone(roll: Scene, folder: Path):
    # Members spread by millimetres: 10 cm is beyond all of them, a micrometre within.
    labels = ["ghostball", "fake:shift=0.1", "fake:shift=1e-6", "fake"]
    found = compared(folder, [roll], labels)
    rest, *others = found.of("roll", "fake:shift=0.1")
    assert rest.quantity == "rest"
    assert rest.differs
    assert rest.test is not None
    assert rest.test.effect > 0.9
    # Two clouds of no width, 0.1 m apart: 2 x 0.1 m.
    assert rest.test.distance == pytest.approx(0.2, rel=0.05)
    assert not any(one.differs for one in others)
    for label in labels[2:]:
        assert not any(one.differs for one in found.of("roll", label))
    assert all(one.test is not None and one.test.p == 1.0 for one in found.of("roll", "fake"))
    assert [one.quantity for one in found.of("roll", "fake")] == list(QUANTITIES)


def test_the_same_physics_in_two_codes_is_not_told_apart_beyond_the_horizon(folder: Path):
    found = compared(folder, [find_scene("chaos-a")], ["ghostball", "paper-continuous"])
    assert not any(one.differs for one in found.comparisons)
    assert found.null.passed is True
    assert "8 tests" not in found.null.sentence  # 4 of the null test
    assert "4 tests in 1 scene," in found.null.sentence


def test_the_null_test_fails_where_our_engine_differs_from_itself(
    roll: Scene, folder: Path, monkeypatch: pytest.MonkeyPatch
):
    def faster(scene, size, index, stream):
        member = perturb(scene, size, index, stream)
        if stream == "shots":
            return member
        cue = member.balls[0].model_copy(update={"velocity": (1.05, 0.0, 0.0)})
        return Scene(name=member.name, balls=[cue])

    monkeypatch.setattr(run_module, "perturb", faster)
    found = compared(folder, [roll], ["ghostball", "fake"])
    assert found.null.passed is False
    assert "rest positions in roll" in found.null.sentence


def test_a_null_test_that_could_not_fail_says_so(roll: Scene, folder: Path):
    found = compared(folder, [roll], ["ghostball", "fake"], count=4)
    assert found.null.passed is None
    assert "Ask for more members" in found.null.sentence


def test_where_no_difference_could_show_nothing_is_judged(roll: Scene, folder: Path):
    few = compared(folder, [roll], ["ghostball", "fake:shift=1.0"], 2)
    assert not any(one.differs or one.judged for one in few.comparisons)


def test_corrected_p_is_over_all_tests_of_the_run_and_can_be_small(folder: Path, roll: Scene):
    other = Scene(name="other", balls=[Ball(id="a", position=(0, 0), velocity=(0.5, 0.0))])
    found = compared(folder, [roll, other], ["ghostball", "fake:shift=0.1"], count=12)
    number = len(found.comparisons)
    assert number == 2 * 2 * len(QUANTITIES)
    assert found.permutations == permutations_for(number)
    assert number / (found.permutations + 1) <= 0.005
    assert permutations_for(1) == 999
    raw = sorted(one.test.p for one in found.comparisons if one.test is not None)
    least = min(one.p for one in found.comparisons if one.p is not None)
    assert least == pytest.approx(number * raw[0])


def test_members_without_an_end_are_left_out_and_counted(roll: Scene, folder: Path):
    found = compared(folder, [roll], ["ghostball", "fake:does=raise"], count=12)
    upward = sum(perturb(roll, Size(), k).balls[0].velocity[1] > 0.0 for k in range(12))
    (rest, *_) = found.of("roll", "fake:does=raise")
    assert (rest.ended, rest.reference_ended) == (12 - upward, 12)
    assert rest.test is not None


def test_too_few_ends_make_no_test(roll: Scene, folder: Path, monkeypatch: pytest.MonkeyPatch):
    real = run_module.run_member

    def failing(task):
        fails = task.label == "fake" and task.index > 0
        return run_module.unended(task, "bad luck") if fails else real(task)

    monkeypatch.setattr(run_module, "run_member", failing)
    found = compared(folder, [roll], ["ghostball", "fake"], count=6)
    assert [(one.ended, one.test, one.p) for one in found.of("roll", "fake")] == [
        (1, None, None)
    ] * len(QUANTITIES)
    assert not any(one.differs for one in found.of("roll", "fake"))
    assert found.null.passed is not False


def test_a_shot_of_a_resting_ball_has_no_energy_and_is_compared_all_the_same(folder: Path):
    still = Scene(name="still", balls=[Ball(id="a", position=(0.0, 0.0))])
    found = compared(folder, [still], ["ghostball", "fake"])
    assert all(one.test is not None and np.isfinite(one.test.effect) for one in found.comparisons)


def test_what_is_compared_is_what_was_run_last(roll: Scene, folder: Path):
    few = compared(folder, [roll], ["ghostball", "fake:shift=0.1"], count=5)
    more = compared(folder, [roll], ["ghostball", "fake:shift=0.1"], count=15)
    assert (few.comparisons[0].ended, more.comparisons[0].ended) == (5, 15)
    assert replace(more.comparisons[0], ended=5) != few.comparisons[0]
