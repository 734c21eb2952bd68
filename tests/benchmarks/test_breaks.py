"""Breaks drawn as arrays are those that scenes have, and their counts are of all of them."""

import numpy as np
from typer.testing import CliRunner

from benchmarks import breaks
from benchmarks.__main__ import app
from benchmarks.breaks import BreaksMeasurement, measure_breaks, starts_of
from benchmarks.scenes import POOL_TABLE, random_rack
from ghostball.engine import simulate
from ghostball.model import Ball, Scene


def scene_of(positions, velocities):
    """The scene of one break, as `random_rack` has it."""
    balls = [
        Ball(**{**dict(ball), "position": tuple(x), "velocity": (*v, 0.0)})
        for ball, x, v in zip(
            random_rack(0).balls, positions.tolist(), velocities.tolist(), strict=True
        )
    ]
    return Scene(name="one", table=POOL_TABLE, physics=random_rack(0).physics, balls=balls)


def test_racks_stand_as_those_of_scenes():
    positions, velocities = starts_of(part=3, count=4)
    frozen = random_rack(1)
    assert np.array_equal(positions[1, 1:], frozen.positions[1:, :2])
    assert np.all(np.diff(positions[0, [1, 2], 0]) > np.diff(positions[1, [1, 2], 0]))
    speeds = np.hypot(*velocities[:, 0].T)
    assert np.all((speeds >= 4.0) & (speeds <= 12.0))
    assert not np.any(velocities[:, 1:])


def test_counts_are_of_all_breaks_and_as_scenes_have_them(monkeypatch):
    monkeypatch.setattr(breaks, "AT_ONCE", 3)
    done = []
    measured = measure_breaks(5, progress=lambda *so_far: done.append(so_far))
    one_by_one = [
        simulate(scene_of(*start))
        for part, count in ((0, 3), (1, 2))
        for start in zip(*starts_of(part, count), strict=True)
    ]
    assert measured.events == sum(result.work["events"] for result in one_by_one)
    assert measured.most_events == max(result.work["events"] for result in one_by_one)
    assert (measured.breaks, measured.not_at_rest) == (5, 0)
    assert [so_far[:2] for so_far in done] == [(3, 5), (5, 5)]


def test_the_command_shows_and_writes_them_and_stores_whole_ones_only(tmp_path):
    arguments = ["breaks", "--count", "4", "--out", str(tmp_path)]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert BreaksMeasurement.load(tmp_path / "breaks.json").breaks == 4
    refused = CliRunner().invoke(app, [*arguments, "--store"])
    assert refused.exit_code == 2
    assert "--count" in refused.output
