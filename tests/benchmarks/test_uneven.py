"""Racks made uneven, and their times beside those of even racks."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks import uneven as benchmark
from benchmarks.scenes import rack_places, racks_made_uneven
from benchmarks.uneven import KINDS, RacksOfKind, UnevenMeasurement, uneven
from ghostball.model import POOL_BALL_RADIUS
from ghostball.model.scene.rack import Rack


@pytest.mark.parametrize("gap", [0.0, 2e-4, 1e-3])
def test_gaps_of_neighbours_are_uneven_and_none_is_negative(gap):
    places = rack_places(np.full(200, gap))
    moved = racks_made_uneven(places, np.full(200, gap), np.random.default_rng(1))
    neighbours = np.linalg.norm(places[0][:, None] - places[0], axis=2)
    near = np.triu(neighbours < 2.0 * POOL_BALL_RADIUS + 1.1 * gap + 1e-9, 1)
    assert near.sum() == 30
    apart = np.linalg.norm(moved[:, :, None] - moved[:, None], axis=3)
    gaps = apart[:, near] - 2.0 * POOL_BALL_RADIUS
    mean = gap or Rack.PRESETS["template"]["gap"]
    assert gaps.min() > -1e-15
    assert gaps.max() < 2.0 * mean + 1e-6 * mean
    assert gaps.mean() == pytest.approx(mean, rel=0.01)
    assert gaps.std() == pytest.approx(mean / np.sqrt(8.0), rel=0.03)


def of_kind(kind: str, *per_break: float) -> RacksOfKind:
    return RacksOfKind(kind=kind, seconds=(1e-4,), per_break=per_break, events=100.0)


def test_a_ratio_compares_times_of_the_same_round():
    kinds = (of_kind("even", 1.0, 10.0, 2.0), of_kind("uneven", 1.5, 16.0, 2.8))
    assert UnevenMeasurement(rounds=3, kinds=kinds).ratio("uneven") == pytest.approx(1.5)


def test_a_small_measurement_is_read_back_and_tabled(tmp_path, monkeypatch):
    monkeypatch.setattr(benchmark, "RACKS", 2)
    monkeypatch.setattr(benchmark, "BREAKS", 3)
    found = uneven(2)
    assert [one.kind for one in found.kinds] == list(KINDS)
    assert all(len(one.seconds) == len(one.per_break) == 2 for one in found.kinds)
    assert UnevenMeasurement.load(found.save(tmp_path)) == found
    assert found.table.row_count == 3
