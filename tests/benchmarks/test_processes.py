"""Fails where the time of a new process is misread, or a failure in it goes unnoticed."""

import pytest

from benchmarks import processes
from benchmarks.processes import COMPILE, SHOOT, timed
from ghostball.validation.results.measurement import MeasurementError

CACHE = "import os; print(len(os.listdir(os.environ['GHOSTBALL_CACHE_DIR'])))"


def test_a_start_is_timed_with_its_import_and_a_cold_one_has_an_empty_cache(monkeypatch):
    monkeypatch.setattr(processes, "SHOOT", "print(0.25)")
    assert processes.prepare_start(None)()["import"] == 0.25
    monkeypatch.setattr(processes, "SHOOT", CACHE)
    monkeypatch.setattr(processes, "COMPILE", CACHE)
    seconds = processes.prepare_cold_start(None)()
    assert seconds.keys() == {"first_shot", "every_variant"}
    assert timed(CACHE, GHOSTBALL_CACHE_DIR="/")[1] > 0.0


@pytest.mark.parametrize(
    ("program", "said"),
    [("raise RuntimeError('no cloth')", "no cloth"), ("import time; time.sleep(60)", "it took")],
)
def test_a_process_that_fails_or_hangs_is_an_error(monkeypatch, program, said):
    monkeypatch.setattr(processes, "LONGEST", 3.0)
    with pytest.raises(MeasurementError, match=said):
        timed(program)


@pytest.mark.parametrize("program", [SHOOT, COMPILE])
def test_the_programs_end(program):
    taken, printed = timed(program, NUMBA_DISABLE_JIT="1")
    assert taken > printed >= 0.0
