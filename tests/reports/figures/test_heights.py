"""Fails where the height of a ball that flies isn't drawn, or is where none flies."""

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.reports import style
from ghostball.reports.figures.heights import flying, part_in_flight
from ghostball.reports.figures.paths import is_collinear
from ghostball.reports.figures.sheet import draw_sheet
from ghostball.reports.figures.single import draw_single
from ghostball.reports.shots import load_shot
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.suite.suite import run_suite


def test_where_a_ball_flies_its_height_is_drawn(tmp_path):
    names = ("flight-jump", "wall-bounce")
    run_suite(list(map(find_scene, names)), ["ghostball"], tmp_path)
    jump, roll = (load_shot(Results.open(tmp_path), name) for name in names)
    assert flying(jump).tolist() == [True, False, False]
    assert not flying(roll).any()
    landed = simulate(find_scene("flight-jump"), record="trajectory")
    assert part_in_flight(jump) == pytest.approx(0.7, abs=0.05)
    high = landed.sample(np.linspace(part_in_flight(jump), landed.rest_time, 50)).positions
    assert np.ptp(high[:, :, 2]) < 1e-4  # a bounce that nobody sees
    for draw in (draw_sheet, draw_single):
        with style.drawing():
            panels = [len(draw(shot).axes) - is_collinear(shot) for shot in (jump, roll)]
        assert panels[0] == panels[1] + 1
