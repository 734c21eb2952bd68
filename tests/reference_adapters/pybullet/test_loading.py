"""A missing pybullet, and its import."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest
from shots import ball, scene_of

from ghostball.reference_adapters.base import EngineError
from ghostball.reference_adapters.pybullet import loading
from ghostball.reference_adapters.pybullet.engine import PybulletEngine


def test_says_why_it_is_unavailable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(loading.importlib.util, "find_spec", lambda name: None)
    reason = PybulletEngine.unavailable()
    assert reason is not None
    assert (
        "no wheels above Python 3.11" if sys.version_info >= (3, 12) else "pip install"
    ) in reason
    loading.load.cache_clear()
    with pytest.raises(EngineError, match="engine `pybullet` is unavailable: pybullet isn't"):
        PybulletEngine().simulate(scene_of(ball((0, 0))))


def test_imports_bullet_late_and_prints_nothing() -> None:
    if PybulletEngine.unavailable():
        pytest.skip(str(PybulletEngine.unavailable()))
    program = """
import sys
from ghostball.model import Ball, Scene, Table
from ghostball.reference_adapters.pybullet.engine import PybulletEngine
assert "pybullet" not in sys.modules
assert PybulletEngine.unavailable() is None
assert "pybullet" not in sys.modules
balls = [Ball(id="cue", position=(0.5, 0.5), velocity=(1, 0)), Ball(id="8", position=(0.8, 0.5))]
scene = Scene(name="roll", balls=balls, table=Table(length=2, width=1), t_max=0.5)
print(PybulletEngine().simulate(scene).to_json())
"""
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stderr == ""
    assert json.loads(done.stdout)["engine"] == "pybullet"
