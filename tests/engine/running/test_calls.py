"""Tests of the memory of shots: nothing is read before it is written, nothing is shared."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from recorded import fingerprint

from ghostball.engine import simulate
from ghostball.engine.running import calls, driver, skips
from ghostball.engine.running.from_scene import layout_of
from ghostball.model import Ball, Scene
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
    monkeypatch.setattr(calls, "memory_for", lambda layout: np.full_like(made(layout), math.nan))


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


@pytest.mark.parametrize("name", ON_CLOTH[:2])
def test_a_shot_in_the_memory_of_an_earlier_shot_has_the_same_bits(name):
    scene = Scene.load(FOLDER / f"{name}.toml")
    first = simulate(scene)
    before = first.rest_positions.copy()
    stopped = simulate(scene, max_events=3)
    stopped_at = stopped.rest_positions.copy()
    recorded = simulate(scene, record="events")
    again = simulate(scene)
    assert stopped.work["events"] == 3
    for other in (recorded, again):
        assert np.array_equal(other.rest_positions, before)
        assert other.work == first.work
    assert np.array_equal(first.rest_positions, before)
    assert np.array_equal(stopped.rest_positions, stopped_at)
    assert len(layout_of(scene).idle) == 1


def test_shots_at_the_same_time_use_different_memory():
    scene = Scene.load(FOLDER / "half-ball-cut.toml")
    runs = [driver.KernelRun(scene, False) for _ in range(3)]
    for run in runs:
        run.go(calls.Limits(1_000, 10**8))
    assert not np.shares_memory(runs[0].final_state().positions, runs[1].final_state().positions)
    for run in runs:
        run.leave()
    assert len({id(place) for place in layout_of(scene).idle}) == 3
    with ThreadPoolExecutor(4) as pool:
        ends = list(pool.map(lambda _: simulate(scene).rest_positions, range(100)))
    assert all(np.array_equal(end, ends[0]) for end in ends)


def test_large_memory_is_not_kept():
    balls = tuple(Ball(id=str(k), position=(0.1 * k, 0.0)) for k in range(300))
    scene = Scene(name="row", balls=balls)
    simulate(scene)
    assert layout_of(scene).block.offsets[-1] > calls._KEPT_NUMBERS
    assert layout_of(scene).idle == []
