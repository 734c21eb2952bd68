"""Projects with baselines, and changes in them."""

from __future__ import annotations

import sys
from dataclasses import replace

import gate
import pytest
from commands import accept, cli, regress, write_config

import ghostball.cli.gate.regress
import ghostball.reference_adapters.ghostball
import ghostball.validation.runs.engine_runs
from ghostball.engine import simulate


@pytest.fixture
def here(tmp_path, monkeypatch, in_this_process):
    """Two scenes in the working directory."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    for scene in (gate.cut_shot(), gate.roll_shot()):
        scene.save(tmp_path / f"{scene.name}.toml")
    return tmp_path


@pytest.fixture
def accepted(here):
    assert regress().exit_code == 4
    assert accept().exit_code == 0
    return here


@pytest.fixture
def planted(monkeypatch):
    """Make Ghostball's engine shift the rest positions of the cut by a nanometre."""

    def lossy(scene, **options):
        result = simulate(scene, **options)
        if scene.name != "cut":
            return result
        state = result.final_state
        return replace(result, final_state=state._replace(positions=state.positions - 1e-9))

    for module in (ghostball.reference_adapters.ghostball, ghostball.validation.runs.engine_runs):
        monkeypatch.setattr(module, "simulate", lossy)


@pytest.fixture
def busier(monkeypatch):
    """Make Ghostball's engine count one more event in the cut and in `stop`, and nothing else."""

    def count(scene, **options):
        result = simulate(scene, **options)
        more = {"events": result.work["events"] + (scene.name in ("cut", "stop"))}
        return replace(result, work={**result.work, **more})

    monkeypatch.setattr(ghostball.reference_adapters.ghostball, "simulate", count)


@pytest.fixture
def project(tmp_path, monkeypatch, in_this_process):
    """A folder with the engine and settings written by `ghostball init`."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.delitem(sys.modules, "my_engine", raising=False)
    assert cli("init").exit_code == 0
    write_config(tmp_path, engines=["my_engine:simulate"], scenes=["stop", "head-on"])
    yield tmp_path
    sys.modules.pop("my_engine", None)
