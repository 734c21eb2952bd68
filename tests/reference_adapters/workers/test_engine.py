"""Engines in a process of their own: their runs come back as any engine's, where they are there."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from echo_worker import worker
from engine_facts import needs, play, rack

from ghostball.engine import simulate
from ghostball.model import UnsupportedSceneError
from ghostball.reference_adapters.registry import EngineUnavailableError, make_engine
from ghostball.reference_adapters.workers import engine as workers
from ghostball.reference_adapters.workers.process import (
    PYTHON,
    Worker,
)
from ghostball.validation.runs.playing import run_engine
from ghostball.validation.scenes.library import find_scene


def test_an_interpreter_without_the_engine_is_absent_and_says_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = tmp_path / "none.py"
    script.write_text("import json; print(json.dumps({'absent': 'no chalk'}))")
    one = Worker([sys.executable, str(script)])
    monkeypatch.setattr(workers, "_worker", lambda *_: one)
    monkeypatch.setenv(PYTHON, sys.executable)
    with pytest.raises(EngineUnavailableError, match="no chalk"):
        make_engine("billiards").simulate(find_scene("galperin-1"))


def test_a_run_that_is_none_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    one = worker(tmp_path, {"status": "rest", "rest_time": "soon"})
    monkeypatch.setattr(workers, "_worker", lambda *_: one)
    monkeypatch.setenv(PYTHON, sys.executable)
    with pytest.raises(Exception, match="`rest_time` of the answer of `billiards` is refused"):
        make_engine("billiards").simulate(find_scene("galperin-1"))
    one.close()


def test_an_interpreter_that_is_not_there_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(PYTHON, "/nowhere/python")
    for name in ("pooltool", "billiards"):
        with pytest.raises(EngineUnavailableError, match="make peers"):
            make_engine(name)


@needs("billiards")
def test_billiards_is_exact() -> None:
    scene = find_scene("galperin-1")
    result = run_engine(make_engine("billiards"), scene)
    truth = simulate(scene, record="events")
    assert np.abs(result.rest_positions - truth.rest_positions).max() < 1e-12
    assert result.collision_counts == truth.collision_counts
    energy = run_engine(make_engine("billiards"), rack()).energy(np.linspace(0, 1, 101)).total
    assert energy == pytest.approx(energy[0], rel=1e-12)
    with pytest.raises(UnsupportedSceneError, match="never slowed"):
        play("billiards", find_scene("draw-shot"))


@needs("pooltool")
@pytest.mark.slow
def test_pooltool_parts_balls_by_a_micrometre() -> None:
    for name in ("follow-shot", "sliding-swerve", "han-check"):
        scene = find_scene(name)
        result = run_engine(make_engine("pooltool"), scene)
        truth = simulate(scene, record="events")
        assert np.abs(result.rest_positions - truth.rest_positions).max() < 2e-6, name
        assert result.collision_counts == truth.collision_counts
    with pytest.raises(UnsupportedSceneError, match="slide before they roll"):
        play("pooltool", find_scene("half-ball-cut"))
