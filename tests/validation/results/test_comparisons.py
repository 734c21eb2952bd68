"""Rest positions, collisions and energy of a case against the truth, as all outputs show them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from stored_records import record

from ghostball.validation.results.comparisons import Comparisons, comparison_row, comparisons_of
from ghostball.validation.results.records import CERTIFIED, OUR_ENGINE
from ghostball.validation.scenes.library import find_scene

SCENE = find_scene("head-on")
CASE = record(
    "mine:Engine",
    SCENE,
    truth=CERTIFIED,
    truth_counts={"ball-ball": 1, "ball-cushion": 0},
    collision_counts={"ball-ball": 1, "ball-cushion": 2},
    ball_errors=np.array([0.001, 0.003]),
    metrics={"rest_error_max": 0.003, "energy_difference_max": 0.25, "energy_difference_time": 1.5},
)


def test_the_three_comparisons_name_the_ball_the_counts_and_the_moment() -> None:
    assert comparisons_of(CASE) == Comparisons(
        rest_error=0.003,
        rest_ball="object",
        counts={"ball-ball": (1, 1), "ball-cushion": (2, 0)},
        energy_difference=0.25,
        energy_time=1.5,
    )


def test_a_row_holds_plain_values_by_column() -> None:
    assert comparison_row(CASE) == {
        "scene": "head-on",
        "label": "mine:Engine",
        "rest_error": 0.003,
        "rest_ball": "object",
        "ball_ball_count": 1,
        "ball_ball_count_true": 1,
        "ball_cushion_count": 2,
        "ball_cushion_count_true": 0,
        "energy_difference": 0.25,
        "energy_difference_time": 1.5,
    }


def test_a_case_that_did_not_run_has_none() -> None:
    lacking = replace(CASE, outcome="not-representable")
    assert comparisons_of(lacking) is None
    assert comparison_row(lacking) == {}


def test_our_engine_is_not_compared_with_itself() -> None:
    ours = replace(CASE, engine="ghostball", truth=OUR_ENGINE)
    nothing = {"ball-ball": (1, None), "ball-cushion": (2, None)}
    assert comparisons_of(ours) == Comparisons(None, None, nothing, None, None)


def test_what_was_not_measured_has_no_value() -> None:
    past = replace(CASE, metrics={"rest_error_max": None}, ball_errors=None, truth_counts=None)
    nothing = {"ball-ball": (1, None), "ball-cushion": (2, None)}
    assert comparisons_of(past) == Comparisons(None, None, nothing, None, None)
