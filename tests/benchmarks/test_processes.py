"""Fails where the time of a new process is misread, or a failure in it goes unnoticed."""

import pytest

from benchmarks import processes
from benchmarks.running import BenchError


def clock_of(*seconds):
    return iter(seconds).__next__


def test_times_are_from_the_start_to_the_shot_and_of_the_import(monkeypatch):
    monkeypatch.setattr(processes, "PROGRAM", "print(0.25)")
    sample = processes.sample_start(None)
    assert sample(clock_of(10.0, 12.5)) == {"first_shot": 2.5, "import": 0.25}


def test_a_cold_start_has_an_empty_cache_of_its_own(monkeypatch):
    program = "import os; print(len(os.listdir(os.environ['GHOSTBALL_CACHE_DIR'])))"
    monkeypatch.setattr(processes, "PROGRAM", program)
    monkeypatch.setattr(processes, "COMPILING", program)
    sample = processes.sample_cold_start(None)
    assert sample(clock_of(0.0, 3.0, 3.0, 8.0)) == {"first_shot": 3.0, "every_variant": 5.0}
    assert processes.first_shot({"GHOSTBALL_CACHE_DIR": "/"}, clock_of(0.0, 1.0))[1] > 0.0


def test_a_failing_process_is_an_error_with_its_last_words(monkeypatch):
    monkeypatch.setattr(processes, "PROGRAM", "raise RuntimeError('no cloth')")
    with pytest.raises(BenchError, match="could not shoot: RuntimeError: no cloth"):
        processes.first_shot({}, clock_of(0.0, 1.0))


def test_a_process_that_cannot_compile_is_an_error_of_its_own(monkeypatch):
    monkeypatch.setattr(processes, "PROGRAM", "print(0.0)")
    monkeypatch.setattr(processes, "COMPILING", "raise RuntimeError('no compiler')")
    with pytest.raises(BenchError, match="could not compile: RuntimeError: no compiler"):
        processes.sample_cold_start(None)(clock_of(0.0, 1.0, 2.0, 3.0))


def test_the_program_that_compiles_ends(monkeypatch):
    monkeypatch.setattr(processes, "LONGEST", 600.0)
    without = {"NUMBA_DISABLE_JIT": "1"}
    assert processes._timed(processes.COMPILING, "compile", without, clock_of(0.0, 1.0)) == (1, 0)


def test_a_process_that_hangs_is_given_up(monkeypatch):
    monkeypatch.setattr(processes, "PROGRAM", "import time; time.sleep(60)")
    monkeypatch.setattr(processes, "LONGEST", 0.2)
    with pytest.raises(BenchError, match="it took over 0 s"):
        processes.first_shot({}, clock_of(0.0, 1.0))


def test_the_program_shoots(monkeypatch):
    monkeypatch.setattr(processes, "LONGEST", 600.0)
    shot, imported = processes.first_shot({"NUMBA_DISABLE_JIT": "1"}, clock_of(0.0, 1.0))
    assert shot == 1.0
    assert imported > 0.0
