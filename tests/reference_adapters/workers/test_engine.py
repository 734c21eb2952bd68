"""Engines in separate processes, if installed: their results are like those of any engine."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from echo_worker import worker

from ghostball.reference_adapters.registry import EngineUnavailableError, make_engine
from ghostball.reference_adapters.workers import engine as workers
from ghostball.reference_adapters.workers.process import PYTHON, Worker
from ghostball.validation.scenes.library import find_scene


def test_an_interpreter_without_the_engine_is_absent_and_says_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = tmp_path / "none.py"
    script.write_text("import json; print(json.dumps({'absent': 'no chalk'}))")
    one = Worker([sys.executable, str(script)])
    monkeypatch.setattr(workers, "worker_of", lambda *_, home: one)
    monkeypatch.setenv(PYTHON, sys.executable)
    with pytest.raises(EngineUnavailableError, match="no chalk"):
        make_engine("billiards").simulate(find_scene("galperin-1"))


def test_a_run_that_is_none_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    one = worker(tmp_path, {"status": "rest", "rest_time": "soon"})
    monkeypatch.setattr(workers, "worker_of", lambda *_, home: one)
    monkeypatch.setenv(PYTHON, sys.executable)
    with pytest.raises(Exception, match="answer of `billiards`: `rest_time` must be a valid"):
        make_engine("billiards").simulate(find_scene("galperin-1"))
    one.close()


def test_an_interpreter_that_is_not_there_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(PYTHON, "/nowhere/python")
    for name in ("pooltool", "billiards"):
        with pytest.raises(EngineUnavailableError, match="make peers"):
            make_engine(name)
