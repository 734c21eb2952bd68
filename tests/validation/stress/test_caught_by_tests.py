"""Bugs that no small trial of the stress suite shows: each fails the test that is named with it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from validation.mutants import Mutant, planted
from validation.stress.mutations import CAUGHT_BY_TESTS, MUTATIONS

ROOT = Path(__file__).parents[3]


def run_on(mutant: Mutant, test: str) -> subprocess.CompletedProcess[str]:
    """Run a test of this checkout on a copy of the engine.

    With interpreted kernels, but where it calls one or two of them a million times.
    """
    environment = dict(mutant.environment)
    if "test_all_pairs.py" in test:
        environment |= {"NUMBA_DISABLE_JIT": "0", "GHOSTBALL_CACHE_DIR": str(mutant.folder)}
    check = f"import engine; assert engine.__file__.startswith({str(mutant.folder)!r})"
    run = f"import pytest, sys; {check}; sys.exit(pytest.main(sys.argv[1:]))"
    options = ["-q", "-n", "0", "-p", "no:cacheprovider", "--rootdir", str(ROOT)]
    options += ["-c", str(ROOT / "pyproject.toml")]
    return subprocess.run(
        [sys.executable, "-c", run, *options, str(ROOT / test)],
        cwd=mutant.folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


def test_names_are_unique():
    names = [mutation.name for mutation in (*MUTATIONS, *(one for one, _ in CAUGHT_BY_TESTS))]
    assert len(set(names)) == len(names)


@pytest.mark.slow
@pytest.mark.checkout
@pytest.mark.parametrize(
    ("mutation", "test"), CAUGHT_BY_TESTS, ids=[one.name for one, _ in CAUGHT_BY_TESTS]
)
def test_a_bug_fails_its_test(mutation, test):
    with planted(mutation) as mutant:
        done = run_on(mutant, test)
    assert done.returncode == 1, done.stdout + done.stderr


@pytest.mark.slow
@pytest.mark.checkout
def test_the_unchanged_engine_passes_them_all():
    with planted() as mutant:
        for test in {test for _, test in CAUGHT_BY_TESTS}:
            done = run_on(mutant, test)
            assert done.returncode == 0, done.stdout + done.stderr
