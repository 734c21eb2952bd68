"""Measured accuracy: what is counted, what is kept of a shot, and what our engine comes to."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import benchmarks.accuracy
from benchmarks.accuracy import AccuracyMeasurement, Distribution, measure_accuracy, shot_of
from ghostball.engine import simulate
from ghostball.model import Scene
from ghostball.validation.parallel.pool import Done
from ghostball.validation.results.measurement import MeasurementError


@pytest.fixture(scope="module")
def in_one_process() -> tuple[AccuracyMeasurement, list[tuple[int, int, str]]]:
    """Return what one process measures, and the progress that it reported."""
    seen: list[tuple[int, int, str]] = []
    measured = measure_accuracy(25, jobs=1, progress=lambda *report: seen.append(report))
    return measured, seen


def test_shots_are_graded_and_counted(
    in_one_process: tuple[AccuracyMeasurement, list[tuple[int, int, str]]],
) -> None:
    measured, seen = in_one_process
    assert seen == [(done, 25, f"shot {done - 1}") for done in range(1, 26)]
    assert measured.shots == 25
    assert sum(measured.endings.values()) == sum(measured.extents.values()) == 25
    assert (measured.missing, measured.invented, measured.faulty) == (0, 0, ())
    assert measured.events == measured.time_error_ulps.count > 100
    assert measured.quality_factor.greatest is not None
    assert measured.quality_factor.greatest < 32
    assert measured.worst[0].quality_factor == measured.quality_factor.greatest
    number = measured.worst[0].number
    again = measure_accuracy(1, first=number, jobs=1)
    assert again.worst == measured.worst[:1]
    assert Scene.model_validate(measured.worst[0].scene) == shot_of(number)


def test_a_shot_that_breaks_a_limit_is_named_with_its_scene(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def short(scene: Scene, **options: Any) -> Any:
        return simulate(scene, **options | {"max_events": 1})

    monkeypatch.setattr(benchmarks.accuracy, "simulate", short)
    measured = measure_accuracy(20, jobs=1)
    assert measured.faulty
    assert measured.missing > 0
    row = measured.faulty[0]
    assert any("events_missing" in fault for fault in row.faults)
    assert any("stopped early" in fault for fault in row.faults)
    assert Scene.model_validate(row.scene) == shot_of(row.number)


def test_a_process_that_crashes_names_the_shot(monkeypatch: pytest.MonkeyPatch) -> None:
    def dying(tasks: Any, jobs: int, work: Any) -> Any:
        yield Done(tasks[0], None, "its process ended with signal 9", "")

    monkeypatch.setattr("benchmarks.accuracy.run_tasks", dying)
    with pytest.raises(MeasurementError, match=r"^the measurement of shot 17: its process ended"):
        measure_accuracy(1, first=17, jobs=1)


def test_a_distribution_is_of_values_that_occur() -> None:
    values = np.arange(1.0, 1001.0)
    spread = Distribution.of(values.tolist())
    assert (spread.count, spread.median, spread.p99, spread.greatest) == (1000, 500, 990, 1000)
    assert Distribution.of([]) == Distribution(count=0)
