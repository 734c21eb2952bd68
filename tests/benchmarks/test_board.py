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
    rows = {label: cells for labels, cells in found.rows() for label in labels}
    assert set(rows) == set(results.labels)
    assert all(sum(map(int, cells[:-3])) == 1 for cells in rows.values())
    assert rows["ghostball"][-3] == "rounding"
    assert "command" not in found.environment


def test_engines_with_the_same_numbers_share_a_row():
    """Fails if the run times keep rows apart, or if a different error doesn't."""
    case = BoardCase(
        scene="stop", label="a", kind="micrometres", error=2e-6, seconds=2.0, engine_seconds=1.0
    )
    others = [{"label": "b", "seconds": 4.0, "engine_seconds": None}, {"label": "c", "error": 3e-6}]
    cases = (case, *(case.model_copy(update=one) for one in others))
    rows = list(BoardMeasurement(environment={}, cases=cases).rows())
    assert [labels for labels, _ in rows] == [["a", "b"], ["c"]]
    assert [cells[-3:] for _, cells in rows] == [
        ("2 µm", "2 s, 4 s", "1 s, –"),
        ("3 µm", "2 s", "1 s"),
    ]


def test_a_run_that_lacks_a_scene_is_refused(results):
    with pytest.raises(MeasurementError, match="has no 'brax-127'"):
        board_of(results)
