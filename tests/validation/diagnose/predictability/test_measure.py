"""How far a shot can be predicted, measured and stored."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from engine import Scene, Status, simulate
from validation.diagnose.predictability import (
    load_predictability,
    predictability_of,
    save_predictability,
)
from validation.diagnose.predictability.prediction_file import PREDICTABILITY_FILE
from validation.results.files import ResultsError
from validation.runs import our_run
from validation.scenes.library import find_scene


def test_neighbouring_shots_part_as_the_tangent_map_says_while_they_are_near():
    known = predictability_of(find_scene("chaos-a"))
    assert known.fragile
    assert known.ends == "growth"
    for separation in known.separations:
        noise = 32.0 * 2.0**-53 * known.growth
        clear = (
            (separation.predicted < 1e-4)
            & (separation.predicted > 30.0 * noise)
            & (separation.predicted > 0.0)
        )
        ratio = separation.apart[clear] / separation.predicted[clear]
        assert np.all((ratio > 0.8) & (ratio < 1.25))
        assert separation.apart[0] == 0.0
    # The paper's 1e-4 changes everything.
    assert known.separations[0].size == 1e-4
    assert known.separations[0].apart[-1] > 1.0


def test_the_growth_is_the_sensitivity_of_the_run():
    scene = find_scene("break-7")
    known = predictability_of(scene)
    result = simulate(scene, record="trajectory")
    assert known.growth[-1] == np.max(result.sensitivity(result.rest_time))
    assert known.horizon is None
    assert (known.ends, known.fragile, known.separations) == ("", False, ())


@pytest.mark.parametrize(
    ("name", "ends"),
    [
        ("three-ball-symmetric", "several collisions at one instant"),
        ("corner-exact", "several collisions at one instant"),
        ("push", "sustained contact"),
    ],
)
def test_what_a_horizon_comes_from(name, ends):
    known = predictability_of(find_scene(name))
    assert known.ends == ends
    assert known.horizon is not None


def test_what_is_stored_reads_back(tmp_path):
    known = [predictability_of(find_scene(name)) for name in ("chaos-a", "push", "stop")]
    save_predictability(tmp_path, known)
    read = load_predictability(tmp_path)
    assert list(read) == ["chaos-a", "push", "stop"]
    for one in known:
        again = read[one.scene]
        assert np.array_equal(again.growth, one.growth, equal_nan=True)
        assert (again.bifurcations, again.nearest) == (one.bifurcations, one.nearest)
        assert len(again.separations) == len(one.separations)
    assert load_predictability(tmp_path / "elsewhere") == {}


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda text: text[:-20], "is cut short"),
        (lambda text: text.replace('"schema":2', '"schema":9'), "`schema` must be 2, got 9"),
        (lambda text: "nonsense\n" + text, r":1: not valid JSON"),
        (lambda text: text.replace('"rest_time"', '"resttime"'), "rest_time"),
    ],
)
def test_a_damaged_file_is_refused_with_its_place(tmp_path, damage, message):
    save_predictability(tmp_path, [predictability_of(find_scene("stop"))])
    path = tmp_path / PREDICTABILITY_FILE
    assert json.loads(path.read_text())["scene"] == "stop"
    path.write_text(damage(path.read_text()))
    with pytest.raises(ResultsError, match=message):
        load_predictability(tmp_path)


def test_a_chaos_scene_in_which_nothing_moves_has_no_neighbours():
    chaos = find_scene("chaos-a")
    balls = [{**one.model_dump(exclude_unset=True), "velocity": (0.0, 0.0)} for one in chaos.balls]
    still = Scene.model_validate({**chaos.model_dump(by_alias=True), "balls": balls})
    assert predictability_of(still).separations == ()


def test_ctrl_c_is_no_shorter_shot(monkeypatch):
    scene = find_scene("stop")
    cut = replace(simulate(scene, record="trajectory"), status=Status.INTERRUPTED)
    monkeypatch.setattr(our_run, "simulate", lambda *_, **__: cut)
    with pytest.raises(KeyboardInterrupt):
        predictability_of(scene)
