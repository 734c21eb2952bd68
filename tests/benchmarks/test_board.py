"""`python -m benchmarks board`: the committed part of a run of the board."""

import pytest
from written_results import LABELS, write_results

from benchmarks import board
from benchmarks.board import BoardCase, BoardMeasurement, board_of
from ghostball.validation.results.measurement import MeasurementError
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.library import find_scene

pytestmark = pytest.mark.checkout


@pytest.fixture
def results(tmp_path):
    return Results.open(write_results(tmp_path / "small", ["stop"], LABELS[:3]))


def test_a_board_has_the_cases_of_a_run_and_committed_cases_of_other_engines(results, monkeypatch):
    stored = BoardMeasurement(
        environment={"cpu": "a processor", "date": "2026-01-02T03:04:05"},
        cases=(
            BoardCase(scene="stop", label="mujoco", kind="micrometres", error=2e-6),
            BoardCase(scene="stop", label="ghostball", kind=None),
        ),
    )
    monkeypatch.setattr(board, "select", lambda _: [find_scene("stop")])
    monkeypatch.setattr(board, "committed", lambda _: stored)
    found = board_of(results)
    assert found.labels == (*results.labels, "mujoco")
    assert found.earlier == {"mujoco": "a processor, 2026-01-02"}
    case = results.case("stop", "pymunk")
    ours = found.of("pymunk")["stop"]
    assert (ours.kind, ours.error) == (case.accuracy.kind, case.accuracy.error)
    assert ours.seconds == case.wall_time
    assert found.of("mujoco")["stop"].text == "2 µm"
    rows = {row[0]: row[1:] for row in found.rows()}
    assert set(rows) == set(results.labels)
    assert all(sum(map(int, row[:-2])) == 1 for row in rows.values())
    assert rows["ghostball"][-2] == "rounding"
    assert "command" not in found.environment


def test_a_run_that_lacks_a_scene_is_refused(results):
    with pytest.raises(MeasurementError, match="has no 'brax-127'"):
        board_of(results)
