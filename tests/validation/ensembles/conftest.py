"""An engine that misbehaves on demand, and a scene of a millisecond."""

import sys
from pathlib import Path

import pytest

from ghostball.engine import Ball, Scene
from ghostball.validation.results.store import ResultsWriter

ENGINE = """
import os

import numpy as np

from ghostball.engine import Result, Status, simulate
from ghostball.engine.scene.features import EXACT, Capability, Feature
from ghostball.reference_adapters.base import EngineBase, EngineSettings


class Settings(EngineSettings):
    does: str = "run"
    shift: float = 0.0


class Fake(EngineBase):
    name = "fake"
    Settings = Settings

    @property
    def capabilities(self):
        able = dict.fromkeys(Feature, EXACT)
        if self.settings.does == "refuse":
            able[Feature.ROLLING] = Capability("none", "it slips")
        return able

    def simulate(self, scene, *, record="rest"):
        self.check(scene)
        truth = simulate(scene, record=record)
        status, final = truth.status, truth.final_state
        if scene.balls[0].velocity[1] > 0.0:  # of half of the members
            if self.settings.does == "raise":
                raise RuntimeError("lost the balls")
            if self.settings.does == "die":
                os._exit(7)
            if self.settings.does == "stop":
                status = Status.STEP_LIMIT
        moved = final._replace(positions=final.positions + [self.settings.shift, 0.0, 0.0])
        return Result(
            engine="fake", settings={}, scene=scene, status=status, final_state=moved,
            rest_time=truth.rest_time, collision_counts=truth.collision_counts, work={},
            wall_time=0.0, events=truth.events, trajectory=truth.trajectory,
        )


class Absent(Fake):
    name = "absent"

    @classmethod
    def unavailable(cls):
        return "not installed here"
"""


@pytest.fixture(autouse=True)
def fake_engine(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """Install the fakes as anyone's package would be: worker processes must find them too."""
    site = tmp_path_factory.mktemp("site")
    (site / "fake_ensemble_engine.py").write_text(ENGINE)
    package = site / "fake_ensemble_engine-1.0.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: fake-ensemble\nVersion: 1.0\n")
    (package / "entry_points.txt").write_text(
        "[ghostball.engines]\n"
        "fake = fake_ensemble_engine:Fake\nabsent = fake_ensemble_engine:Absent\n"
    )
    monkeypatch.syspath_prepend(str(site))
    monkeypatch.delitem(sys.modules, "fake_ensemble_engine", raising=False)


@pytest.fixture
def roll() -> Scene:
    """Return a shot of one ball on an unbounded cloth."""
    return Scene(name="roll", balls=[Ball(id="cue", position=(0.0, 0.0), velocity=(1.0, 0.0))])


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a results folder without cases."""
    writer = ResultsWriter(tmp_path / "out")
    writer.begin({"scenes": [], "engines": []})
    writer.finish("complete")
    return writer.path
