import dataclasses

import numpy as np
import pytest

from benchmarks import processes, scenes
from benchmarks.processes import COMPILE_PROGRAM, FIRST_SHOT_PROGRAM, timed
from benchmarks.scenes import run
from benchmarks.workloads import prepare_air
from ghostball.model import POOL_BALL_RADIUS as R, Status
from ghostball.validation.results.measurement import MeasurementError
from ghostball.validation.scenes.gases import FRICTIONLESS, packed_gas
from ghostball.validation.scenes.library import find_scene

# The samples of `benchmarks.workloads`; test_speed checks that each sample has its targets


def test_slides_are_played_with_air_and_without():
    sample = prepare_air(True)()
    assert sample.keys() == {"slide", "over_no_air"}
    assert all(value > 0.0 for value in sample.values())


# The time of a new process is read correctly, and a failure in the process is an error


CACHE = "import os; print(len(os.listdir(os.environ['GHOSTBALL_CACHE_DIR'])))"


def test_a_start_is_timed_with_its_import_and_a_cold_one_has_an_empty_cache(monkeypatch):
    monkeypatch.setattr(processes, "FIRST_SHOT_PROGRAM", "print(0.25)")
    assert processes.prepare_start(None)()["import"] == 0.25
    monkeypatch.setattr(processes, "FIRST_SHOT_PROGRAM", CACHE)
    monkeypatch.setattr(processes, "COMPILE_PROGRAM", CACHE)
    seconds = processes.prepare_cold_start(None)()
    assert seconds.keys() == {"first_shot", "every_variant"}
    assert timed(CACHE, GHOSTBALL_CACHE_DIR="/")[1] > 0.0


@pytest.mark.parametrize(
    ("program", "said"),
    [("raise RuntimeError('no cloth')", "no cloth"), ("import time; time.sleep(60)", "it took")],
)
def test_a_process_that_fails_or_hangs_is_an_error(monkeypatch, program, said):
    monkeypatch.setattr(processes, "PROCESS_TIME_LIMIT", 3.0)
    with pytest.raises(MeasurementError, match=said):
        timed(program)


@pytest.mark.parametrize("program", [FIRST_SHOT_PROGRAM, COMPILE_PROGRAM])
def test_the_programs_end(program):
    taken, printed = timed(program, NUMBA_DISABLE_JIT="1")
    assert taken > printed >= 0.0


# A generated scene agrees with its description, and is valid as a scene file


NEIGHBOURS = 30


def gaps_of(scene):
    """Return the gaps of all pairs of racked balls in a scene, the smallest first [m]."""
    racked = scene.positions[1:, :2]
    between = np.linalg.norm(racked[:, None] - racked[None], axis=2)[np.triu_indices(15, 1)]
    return np.sort(between - 2 * R)


@pytest.mark.parametrize("number", range(4))
def test_random_racks_are_loose_and_frozen_alternately(number):
    scene = scenes.random_rack(number)
    assert scene == scenes.random_rack(number)
    assert len(scene.balls) == 16
    assert 4.0 <= scene.balls[0].speed <= 12.0
    gaps = gaps_of(scene)
    assert gaps[NEIGHBOURS] > 0.7 * 2 * R  # of the others
    if number % 2:
        assert np.all(np.abs(gaps[:NEIGHBOURS]) < 1e-15)
    else:
        assert 0.0 < gaps[0] <= 1e-3
        assert np.ptp(gaps[:NEIGHBOURS]) < 1e-15


def test_frozen_racks_touch_as_the_shipped_one_does_to_the_bit():
    shipped = find_scene("frozen-break")
    frozen = scenes.random_rack(1)
    assert np.array_equal(frozen.positions[1:], shipped.positions[1:])


def test_a_run_that_broke_off_is_no_measurement(monkeypatch):
    simulate = scenes.simulate
    monkeypatch.setattr(
        scenes,
        "simulate",
        lambda *a, **k: dataclasses.replace(simulate(*a, **k), status=Status.FAILED),
    )
    with pytest.raises(MeasurementError):
        run(packed_gas(2, 0.1, FRICTIONLESS, 0.1))
