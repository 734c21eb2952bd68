"""Every planted bug is caught, by what it says; a copy without one passes all of that."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from copies import INSTALLED
from mutants import Mutation, faults_on, outcome_of_interpreted_tests, planted
from mutations import MUTATIONS

from ghostball.validation.scenes.library import scene_names
from ghostball.validation.stress import StressSize, chosen_shots

ROOT = Path(__file__).parents[2]

BY_SHOTS = [one for one in MUTATIONS if not one.caught_by.startswith("tests/")]
BY_TESTS = [one for one in MUTATIONS if one.caught_by.startswith("tests/")]


def test_names_are_unique():
    assert len({one.name for one in MUTATIONS}) == len(MUTATIONS) > 40


def test_what_catches_a_bug_is_there():
    wanted = {one.caught_by for one in BY_SHOTS}
    shipped = {name for name in wanted if name.startswith("shipped/")}
    assert shipped <= {f"shipped/{name}" for name in scene_names()}
    generated = sorted(wanted - shipped)
    assert len(chosen_shots(StressSize(), generated)) == len(generated)
    for one in BY_TESTS:
        file, _, name = one.caught_by.partition("::")
        function = name.partition("[")[0].rpartition("::")[2]
        assert f"def {function}(" in (ROOT / file).read_text("utf-8")


def test_every_mutation_fits(tmp_path):
    for mutation in MUTATIONS:
        copy = tmp_path / "ghostball" / mutation.file
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes((INSTALLED / mutation.file).read_bytes())
        mutation.apply(tmp_path)
        compile(copy.read_text("utf-8"), mutation.file, "exec")


@pytest.mark.slow
@pytest.mark.parametrize("mutation", BY_SHOTS, ids=lambda one: one.name)
def test_a_bug_is_caught_by_its_shot(mutation: Mutation):
    with planted(mutation) as folder:
        found = faults_on(folder, [mutation.caught_by])
    assert found[mutation.caught_by], f"survived, though {mutation.what}"


@pytest.mark.slow
def test_without_a_bug_no_shot_fails():
    shots = list(dict.fromkeys(one.caught_by for one in BY_SHOTS))
    with planted() as folder:
        assert faults_on(folder, shots) == dict.fromkeys(shots, ())


def is_interpreted(test: str) -> bool:
    """Whether a test runs interpreted kernels: not where it calls one or two a million times."""
    return "test_all_pairs.py" not in test


def outcome_on(folder: Path, *tests: str) -> tuple[int | None, str]:
    """Run tests of this checkout on a copy of the engine; return exit status and output."""
    if all(is_interpreted(test) for test in tests):
        return outcome_of_interpreted_tests(folder, ROOT, tests)
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join([str(folder), *filter(None, sys.path)]),
        "NUMBA_DISABLE_JIT": "0",
        "GHOSTBALL_CACHE_DIR": str(folder),
    }
    run = [sys.executable, "-m", "probe", str(folder), str(ROOT), *tests]
    # Python looks for packages in the present folder first.
    done = subprocess.run(
        run, cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    return done.returncode, done.stdout + done.stderr


@pytest.mark.slow
@pytest.mark.checkout
@pytest.mark.parametrize("mutation", BY_TESTS, ids=lambda one: one.name)
def test_a_bug_fails_its_test(mutation: Mutation):
    with planted(mutation) as folder:
        status, output = outcome_on(folder, mutation.caught_by)
    assert status == pytest.ExitCode.TESTS_FAILED, output
    # A Python program that ends by an exception has the same exit status.
    assert re.search(r"^\d+ failed", output, re.MULTILINE), output


@pytest.mark.slow
@pytest.mark.checkout
@pytest.mark.parametrize("interpreted", [True, False])
def test_without_a_bug_every_test_passes(interpreted):
    tests = {one.caught_by for one in BY_TESTS if is_interpreted(one.caught_by) == interpreted}
    with planted() as folder:
        status, output = outcome_on(folder, *tests)
    assert status == pytest.ExitCode.OK, output
