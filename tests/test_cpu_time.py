"""What tests cost is measured, shown and judged, whether workers of xdist run them or not.

The clock is the scratch repository's own: each of its tests says what it costs.
"""

from pathlib import Path

import pytest

pytest_plugins = ["pytester"]

CLOCK = """
import cpu_time
import pytest

seconds = [0.0]
cpu_time.used = lambda: seconds[0]

@pytest.fixture
def spend():
    def spend(amount):
        seconds[0] += amount
    return spend

@pytest.fixture
def costly(spend):
    spend(4.0)
"""
TESTS = """
import pytest

def test_cheap(spend):
    spend(4.5)

def test_dear(spend):
    spend(6.5)

def test_dear_with_its_fixture(costly, spend):
    spend(2.0)

@pytest.mark.slow
def test_marked(spend):
    spend(100.0)
"""


@pytest.fixture(params=["0", "2"], ids=["alone", "workers"])
def run(request, pytester, monkeypatch):
    """Run the scratch tests in a process of their own."""

    def run(tests, *arguments):
        pytester.makeini("[pytest]\nmarkers = slow: takes long")
        pytester.makeconftest(CLOCK)
        pytester.makepyfile(tests)
        return pytester.runpytest_subprocess(
            "-p", "no:hypothesispytest", "-p", "cpu_time", "-n", request.param, *arguments
        )

    monkeypatch.delenv("PYTEST_ADDOPTS", raising=False)
    monkeypatch.setenv("PYTHONPATH", str(request.config.rootpath / "tests" / "support"))
    return run


def test_a_test_that_costs_too_much_fails_the_run(run):
    result = run(TESTS, "--cpu-limit=5")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.assert_outcomes(passed=4)  # the run fails, and not the tests
    result.stdout.fnmatch_lines(
        [
            "*10 tests that cost most*",
            "*100.00 s  *::test_marked",
            "  6.50 s  *::test_dear",
            "  6.00 s  *::test_dear_with_its_fixture",
            "  4.50 s  *::test_cheap",
            "*tests that cost too much*",
        ]
    )
    result.stdout.fnmatch_lines_random(
        [
            "*::test_dear took 6.5 s of the processor, and 5 s is the most.*",
            "*::test_dear_with_its_fixture took 6.0 s *",
        ]
    )
    result.stdout.no_fnmatch_line("*test_cheap took*")
    result.stdout.no_fnmatch_line("*test_marked took*")


def test_cheap_tests_and_those_marked_slow_pass(run):
    result = run(TESTS, "--cpu-limit=5", "-k", "not dear")
    assert result.ret == pytest.ExitCode.OK
    result.stdout.no_fnmatch_line("*cost too much*")


def test_on_a_slow_machine_all_tests_are_dear_and_none_fails_the_run(run):
    cheap = "".join(f"\ndef test_{n}(spend):\n    spend(10.0)\n" for n in range(80))
    result = run(cheap, "--cpu-limit=5")  # of 800 s a test may take 12
    assert result.ret == pytest.ExitCode.OK
    result.stdout.no_fnmatch_line("*cost too much*")
    result = run(cheap + "\ndef test_dear(spend):\n    spend(13.0)\n", "--cpu-limit=5")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(["*::test_dear took 13.0 s of the processor, and 12 s is *"])


def test_without_a_limit_nothing_is_said(run):
    result = run(TESTS)
    assert result.ret == pytest.ExitCode.OK
    result.stdout.no_fnmatch_line("*cost*")


LATE = """
import subprocess
import sys

WORK = (
    "import sys, time\\nwhile time.process_time() < 1.0: pass\\n"
    "print(flush=True)\\nsys.stdin.read()"
)
started = []

COMMAND = [sys.executable, "-c", WORK]
if {of_a_child}:
    COMMAND = ["sh", "-c", '"$0" "$@"; true', *COMMAND]

def test_begins():
    pipe = subprocess.PIPE
    started.append(subprocess.Popen(COMMAND, stdin=pipe, stdout=pipe))
    started[0].stdout.readline()

def test_ends():
    started[0].communicate()
"""


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="the system doesn't tell")
@pytest.mark.parametrize("of_a_child", [False, True], ids=["a child", "a child's child"])
def test_what_a_process_did_before_a_test_costs_that_test_nothing(
    pytester, monkeypatch, request, of_a_child
):
    monkeypatch.delenv("PYTEST_ADDOPTS", raising=False)
    monkeypatch.setenv("PYTHONPATH", str(request.config.rootpath / "tests" / "support"))
    pytester.makeini("[pytest]")
    pytester.makepyfile(LATE.replace("{of_a_child}", str(of_a_child)))
    plugins = ("-p", "no:hypothesispytest", "-p", "cpu_time", "-n", "0")
    result = pytester.runpytest_subprocess(*plugins, "--cpu-limit=0.5")
    result.assert_outcomes(passed=2)
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(["*::test_begins took *"])
    result.stdout.no_fnmatch_line("*::test_ends took *")
