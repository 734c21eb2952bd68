"""Measured accuracy: what is counted, what is kept of a shot, and what our engine comes to."""

from __future__ import annotations

from typing import Any

import pytest

from benchmarks.accuracy import AccuracyMeasurement, accuracy, shot_of
from ghostball.engine import simulate
from ghostball.model import Scene
from ghostball.validation.parallel.pool import Done
from ghostball.validation.results.measurement import MeasurementError


def test_shots_are_graded_and_counted() -> None:
    measured: AccuracyMeasurement = accuracy(25, jobs=1)
    assert measured.shots == 25
    assert sum(measured.endings.values()) == sum(measured.extents.values()) == 25
    assert (measured.missing, measured.invented, measured.faulty) == (0, 0, ())
    assert measured.events == measured.time_error_ulps.count > 100
    assert measured.quality_factor.greatest is not None
    assert measured.quality_factor.greatest < 32
    assert measured.worst[0].quality_factor == measured.quality_factor.greatest
    number = measured.worst[0].number
    again = accuracy(1, first=number, jobs=1)
    assert again.worst == measured.worst[:1]
    assert Scene.model_validate(measured.worst[0].scene) == shot_of(number)


def test_a_shot_that_breaks_a_limit_is_named_with_its_scene(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def short(scene: Scene, **options: Any) -> Any:
        return simulate(scene, **options | {"max_events": 1})

    monkeypatch.setattr("benchmarks.accuracy.simulate", short)
    measured = accuracy(20, jobs=1)
    assert measured.faulty
    assert measured.missing > 0
    row = measured.faulty[0]
    assert any("events_missing" in fault for fault in row.faults)
    assert any("stopped early" in fault for fault in row.faults)
    assert Scene.model_validate(row.scene) == shot_of(row.number)


def test_a_process_that_crashes_names_the_shot(monkeypatch: pytest.MonkeyPatch) -> None:
    def dying(tasks: Any, jobs: int, work: Any) -> Any:
        yield Done(tasks[0], None, "its process ended with signal 9", "")

    monkeypatch.setattr("benchmarks.frame.run_tasks", dying)
    with pytest.raises(MeasurementError, match=r"^the measurement of shot 17: its process ended"):
        accuracy(1, first=17, jobs=1)
