"""`import validation` provides its names, and imports no large package."""

from __future__ import annotations

import subprocess
import sys

import pytest

from ghostball import validation


def test_every_name_is_where_it_is_said_to_be():
    assert "run_suite" in validation.__all__
    for name in validation.__all__:
        assert name in dir(validation)
        assert getattr(validation, name) is not None


def test_a_name_that_is_none_is_refused():
    with pytest.raises(AttributeError, match="run_sweet"):
        _ = validation.run_sweet


def test_a_process_for_tasks_imports_nothing_of_what_they_do():
    # Fails if each process of a pool imports the whole suite before its first task.
    names = ("ghostball.engine", "numpy", "numba", "ghostball.validation.suite.suite")
    heavy = f"[name for name in {names} if name in modules]"
    code = f"import ghostball.validation.parallel.pool; from sys import modules; print({heavy})"
    found = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout
    assert found.strip() == "[]"
