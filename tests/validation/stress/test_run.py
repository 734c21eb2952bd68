"""A stress run: what is asked for, what stands from earlier runs, and what a fault costs."""

from __future__ import annotations

import multiprocessing
import sys

import pytest

import validation.stress.run
from engine import GhostballError
from validation.stress import run_stress
from validation.stress.faulty_engine import planted
from validation.stress.records import FINDINGS_FILE, StressFolder

ONE = ["grazing/rolling-hit-1e-01"]
TWO = [*ONE, "grazing/rolling-miss-1e-01"]


@pytest.fixture
def faulty(tmp_path, monkeypatch):
    """Install the faulty engine as anyone's package would be."""
    monkeypatch.syspath_prepend(str(planted(tmp_path / "site")))
    assert sys.path[0] == str(tmp_path / "site")


@pytest.mark.parametrize(
    ("labels", "options", "message"),
    [
        ([], {}, "at least one engine"),
        (["ghostball", "ghostball"], {}, "once, got ghostball again"),
        (["no-such-engine"], {}, "no-such-engine"),
        (["pymunk:dt=fast"], {}, "dt"),
        (["ghostball"], {"jobs": 0}, "`jobs` must be at least 1"),
        (["ghostball"], {"time_limit": 0.0}, "`time_limit` must be a positive number"),
        (["ghostball"], {"time_limit": float("nan")}, "`time_limit` must be a positive number"),
        (["ghostball"], {"only": ["grasing"]}, "'grasing'. Families: "),
        (["ghostball"], {"only": ["grazing/*-9e-99"]}, "'grazing/*-9e-99'"),
    ],
)
def test_what_is_wrong_is_refused_before_anything_is_written(tmp_path, labels, options, message):
    with pytest.raises(GhostballError) as caught:
        run_stress(labels, tmp_path / "out", **options)
    assert message in str(caught.value)
    assert not (tmp_path / "out").exists()


def test_a_run_is_kept_and_taken_over_by_the_same_code_alone(tmp_path, monkeypatch):
    first = run_stress(["ghostball"], tmp_path, only=TWO)
    assert first.exit_status == 0
    assert (first.taken_over, len(first.folder.findings)) == (0, 2)
    again = run_stress(["ghostball"], tmp_path, only=TWO)
    assert again.taken_over == 2
    # Cut short by a kill in the midst of the last line: that one is tried again.
    path = tmp_path / FINDINGS_FILE
    path.write_bytes(path.read_bytes()[:-5])
    assert run_stress(["ghostball"], tmp_path, only=TWO).taken_over == 1
    lines = path.read_text().replace(first.folder.findings[0].code_hash, "0" * 64)
    path.write_text(lines)
    assert run_stress(["ghostball"], tmp_path, only=TWO).taken_over == 0
    assert len(StressFolder.load(tmp_path).findings) == 2


def test_ctrl_c_keeps_what_is_done(tmp_path):
    def interrupt(*_):
        raise KeyboardInterrupt

    outcome = run_stress(["ghostball"], tmp_path, only=TWO, progress=interrupt)
    assert outcome.interrupted
    assert outcome.exit_status == 130
    folder = StressFolder.load(tmp_path)
    assert len(folder.findings) == 1
    assert not folder.whole
    assert multiprocessing.active_children() == []


@pytest.mark.usefixtures("faulty")
def test_an_engine_that_crashes_or_hangs_costs_its_trial(tmp_path):
    labels = ["faulty:does=die", "faulty:does=hang", "faulty:does=exit", "faulty"]
    outcome = run_stress(labels, tmp_path / "out", only=ONE, time_limit=5.0)
    found = {one.label: one for one in outcome.folder.findings}
    assert found["faulty"].outcome == "survived"
    for label, says in zip(labels, ("exit code 7", "longer than 5 s", "SystemExit"), strict=False):
        assert found[label].outcome == "broken"
        assert says in found[label].faults[0]
    assert found["faulty:does=die"].scene is not None  # the shot of which it died
    assert outcome.exit_status == 1
    assert multiprocessing.active_children() == []


def test_a_limit_of_time_only_shortens_that_of_a_trial(tmp_path, monkeypatch):
    seen = []

    def tasks_done(tasks, jobs, work, died, limit):
        seen.extend(limit(task) for task in tasks)
        yield from ()

    monkeypatch.setattr(validation.stress.run, "run_tasks", tasks_done)
    for seconds in (None, 1.0, 1e6):
        run_stress(["pymunk"], tmp_path / str(seconds), only=ONE, time_limit=seconds)
    assert seen == [60.0, 1.0, 60.0]
