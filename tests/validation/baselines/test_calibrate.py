"""The noise of a machine: how far the same code differs between processes, and the thresholds."""

from __future__ import annotations

import sys
from contextlib import contextmanager

import gate
import pytest
from hypothesis import given, strategies as st

from validation.baselines.calibrate import LEAST_THRESHOLD, MARGIN, calibrate, times_of
from validation.baselines.player import NotComparableError
from validation.baselines.timing import load_times, save_times, times_path
from validation.bench.measurements import measured_where
from validation.results.environment import describe_environment

MODULE = sys.modules[calibrate.__module__]
"""The module: in its package, the function is called like it."""

SCENES = [gate.cut_shot(), gate.roll_shot()]


@pytest.fixture
def processes(monkeypatch):
    """Stand for processes: each takes its own time, and what it was asked is noted."""
    asked = []

    class Process:
        def __init__(self, number):
            self.number = number

        def seconds(self, path, runs):
            asked.append((self.number, path.name))
            return 1.0 + 0.1 * self.number

    @contextmanager
    def playing(name, root):
        assert (root / "engine").is_dir()
        yield Process(int(name.split()[-1]) - 1)

    monkeypatch.setattr(MODULE, "playing", playing)
    return asked


def test_the_largest_difference_of_two_processes_is_the_noise(processes):
    times = calibrate(SCENES, processes=3, rounds=2)
    assert set(times.scenes) == {"cut", "roll"}
    assert times.processes == 3
    for one in times.scenes.values():
        assert (one.median, one.low, one.high, one.samples) == (1.1, 1.0, 1.2, 6)
        assert one.noise == pytest.approx(1.2)
        assert one.threshold == pytest.approx(1.0 + MARGIN * 0.2)


def test_processes_take_turns_and_each_goes_first(processes):
    calibrate(SCENES[:1], processes=2, rounds=2)
    assert [number for number, _ in processes] == [0, 1, 1, 0]


def test_each_scene_is_its_own_file(processes):
    calibrate(SCENES, processes=2, rounds=1)
    assert len({name for _, name in processes}) == 2


def test_what_was_measured_is_read_back_where_regress_looks(processes, tmp_path):
    times = calibrate(SCENES, processes=2, rounds=1)
    path = times_path(tmp_path, times.environment)
    assert path == times_path(tmp_path, describe_environment()) != tmp_path
    assert path == times_path(tmp_path, measured_where())
    save_times(times, path)
    assert load_times(path) == times


def test_progress_counts_rounds(processes):
    told = []
    calibrate(SCENES, processes=2, rounds=3, progress=lambda *step: told.append(step[:2]))
    assert told == [(1, 3), (2, 3), (3, 3)]


@given(st.lists(st.lists(st.floats(1e-7, 1.0), min_size=1, max_size=6), min_size=2, max_size=6))
def test_no_process_is_called_slower_than_another(samples):
    # A threshold within the noise would fail builds that changed nothing.
    found = times_of(samples)
    assert found.threshold >= max(LEAST_THRESHOLD, found.noise)
    assert found.low <= found.median <= found.high
    assert found.samples == sum(map(len, samples))


def test_a_process_that_ends_leaves_no_half_calibration(monkeypatch):
    @contextmanager
    def playing(name, root):
        class Process:
            def seconds(self, path, runs):
                raise NotComparableError(f"{name} ended")

        yield Process()

    monkeypatch.setattr(MODULE, "playing", playing)
    with pytest.raises(NotComparableError, match="process 1 ended"):
        calibrate(SCENES)


@pytest.mark.slow
def test_real_processes_are_timed():
    times = calibrate(SCENES[1:], processes=2, rounds=2)
    assert times.scenes["roll"].samples == 4
    assert 0.0 < times.scenes["roll"].low < 1.0
