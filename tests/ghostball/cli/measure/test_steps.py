"""`ghostball engines --steps`: error against time, the recommended step, and bad input."""

import inspect
import json
import sys
from functools import partial

import pytest

from ghostball.validation.examples import first_engine
from ghostball.validation.precision.points import PrecisionMeasurement
from ghostball.validation.runs import time_steps


@pytest.fixture
def measured(cli, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(time_steps, "MOST_LEVELS", 4)
    return partial(cli, "engines", "--steps")


def test_reached_accuracies_are_printed_written_and_drawn(measured, tmp_path):
    engines = ("ghostball", "pymunk:contact_steps=exact")
    options = ("--repeats", 1, "-o", tmp_path / "out", "--plot", "steps.png")
    found = measured(*engines, "--scene", "half-ball-cut", *options)
    assert found.exit_code == 0, found.output
    for part in ("half-ball-cut (closed form)", "to 1 mm", "ghostball", "drawn in steps.png"):
        assert part in found.stdout
    assert (tmp_path / "steps.png").stat().st_size > 10_000
    kept = PrecisionMeasurement.load(tmp_path / "out" / "precision.json")
    assert {point.engine for point in kept.points} == set(engines)


def test_an_own_engine_is_told_its_step(measured, tmp_path):
    # A function with a `dt`, named in the project's settings, as in the README.
    (tmp_path / "own_steps.py").write_text(inspect.getsource(first_engine), "utf-8")
    settings = '[tool.ghostball]\nengines = ["own_steps:simulate"]\n'
    (tmp_path / "pyproject.toml").write_text(settings, "utf-8")
    found = measured("--scene", "stop", "--scene", "draw-shot", "--repeats", 1, "--format", "json")
    sys.modules.pop("own_steps", None)
    assert found.exit_code == 0, found.output
    points = json.loads(found.stdout)["points"]
    assert [one["step"] for one in points] == [0.016, 0.008, 0.004, 0.002]
    assert "own_steps:simulate: recommended step " in found.stderr
    assert "draw-shot, own_steps:simulate" in found.stderr  # left out, and why


def test_if_no_scene_is_supported_nothing_is_judged(measured):
    found = measured("paper-discrete", "--scene", "draw-shot", "--plot", "none.png")
    assert found.exit_code == 4, found.output
    assert "unsupported" in found.stdout
