"""`python -m benchmarks steps`: each column over an engine's step, its knee, its picture."""

import math

import pytest
from step_points import points

from benchmarks.steps import (
    COLUMNS,
    error_text,
    knee,
    measure_steps,
    stepped,
)

pytestmark = pytest.mark.checkout


def test_every_column_that_a_step_can_decide_is_measured():
    assert set(COLUMNS) == {
        *("cut", "exact-steps", "line", "two", "break", "slide", "throw"),
        *("slow", "gas", "pocket", "jaws"),
    }


def test_a_step_is_worth_it_until_four_times_as_many_do_not_halve_the_error():
    halved = {60: None, 120: 8e-4, 240: 4e-4, 480: 3e-4, 960: 2.9e-4}
    worth = knee(COLUMNS["cut"], points("cut", "pymunk", halved))
    assert worth is not None
    assert worth.steps == 240
    assert knee(COLUMNS["cut"], points("cut", "pymunk", {60: None, 120: None})) is None
    # What is lucky isn't worth it.
    lucky = {60: 8e-4, 120: 1e-9, 240: 4e-4, 480: 4e-4, 960: None, 1920: 3e-4}
    assert knee(COLUMNS["cut"], points("cut", "pymunk", lucky)).steps == 1920
    assert knee(COLUMNS["cut"], points("cut", "pymunk", lucky | {960: 4e-4})).steps == 120
    # What a threshold calls right is right with the coarsest step.
    kept = knee(COLUMNS["break"], points("break", "pymunk", {60: 2e-3, 120: 5e-5, 240: 1e-15}))
    assert kept is not None
    assert kept.steps == 120


def test_errors_are_told_as_on_the_board():
    (off,) = points("cut", "pymunk", {60: 1.5e-4})
    (other,) = points("cut", "pymunk", {60: None})
    (short,) = points("pocket", "pymunk", {60: 18.28})
    assert error_text(COLUMNS["cut"], off) == "150 µm"
    assert error_text(COLUMNS["cut"], other) == "other shot"
    assert error_text(COLUMNS["pocket"], short) == "18.3° short"


def test_a_step_is_put_into_the_label_with_no_limit_in_its_way():
    assert stepped("pymunk", 500) == "pymunk:dt=0.002,max_steps=1000000"


def test_an_exact_engine_has_no_steps_and_one_that_steps_errs_less_with_finer_ones(monkeypatch):
    pytest.importorskip("pymunk")
    monkeypatch.setattr("benchmarks.steps.COLUMNS", {"cut": COLUMNS["cut"]})
    monkeypatch.setattr("benchmarks.steps.STEPS", (240, 960))
    monkeypatch.setattr("benchmarks.steps.TIME_LIMIT", None)
    measured = measure_steps(["ghostball", "pymunk"])
    found = measured.of("cut")
    assert set(found) == {"pymunk"}
    coarse, fine = (one.error for one in found["pymunk"])
    # Of the worst of four phases: at 1.5 m/s some millimetres for each millisecond of a step.
    assert math.isclose(coarse / fine, 4.0, rel_tol=0.1)
