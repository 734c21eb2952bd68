"""Tests of the memory in which shots are simulated: nothing is read before it is written."""

from __future__ import annotations

import math

import numpy as np
import pytest
from recorded import fingerprint

from ghostball.engine import simulate
from ghostball.engine.running import calls, driver, skips
from ghostball.model import Scene
from ghostball.validation.scenes.library import FOLDER

ON_CLOTH = ["break-7", "frozen-triangle", "push-line"]
PLAYED = [
    *((name, many) for name in ON_CLOTH for many in (False, True)),
    ("air-slides", False),  # in cells, this scene would need kernels that no other test needs
    ("flight-jump", False),
]


def pause_at_every_step(monkeypatch):
    monkeypatch.setattr(driver.KernelRun.play, "__defaults__", (1,))


def fill_scratch_with_nan(monkeypatch):
    made = calls.memory_for
    monkeypatch.setattr(driver, "memory_for", lambda layout: np.full_like(made(layout), math.nan))


@pytest.mark.compiled
@pytest.mark.parametrize("disturb", [pause_at_every_step, fill_scratch_with_nan])
@pytest.mark.parametrize(("name", "many"), PLAYED)
def test_pauses_and_scratch_contents_change_no_bit(name, many, disturb, monkeypatch):
    """Nothing in a block is read before it is written, and a shot continues where it paused."""
    if many:
        monkeypatch.setattr(skips, "MOST_PAIRED", 0)
    scene = Scene.load(FOLDER / f"{name}.toml")
    whole = simulate(scene.model_copy(), record="events")
    disturb(monkeypatch)
    other = simulate(scene.model_copy(), record="events")
    assert fingerprint(other) == fingerprint(whole)
    assert other.work == whole.work
