"""How far a shot can be predicted, measured and stored."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ghostball.engine import Scene, Status, simulate
from ghostball.validation.diagnose.predictability import (
    PredictionStore,
    load_predictability,
    predictability_of,
)
from ghostball.validation.runs import our_run
from ghostball.validation.scenes.library import find_scene


def test_neighbouring_shots_part_as_the_tangent_map_says_while_they_are_near():
    known = predictability_of(find_scene("chaos-a"))
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
    assert (known.ends, known.separations) == ("", ())


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
    store = PredictionStore(tmp_path, "code")
    store.begin({})
    for one in known:
        store.write(one, "key")
    store.finish("complete")
    read = load_predictability(tmp_path)
    assert list(read) == ["chaos-a", "push", "stop"]
    for one in known:
        again = read[one.scene]
        assert np.array_equal(again.growth, one.growth, equal_nan=True)
        assert (again.horizon, again.ends) == (one.horizon, one.ends)
        assert len(again.separations) == len(one.separations)
    assert load_predictability(tmp_path / "elsewhere") == {}


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
