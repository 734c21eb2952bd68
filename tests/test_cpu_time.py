"""What tests cost is measured and shown, whether workers of xdist run them or not.

The clock is the scratch repository's own: each of its tests says what it costs.
"""

import re
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


def test_what_tests_cost_is_printed_and_fails_no_run(run):
    """A limit on it refused changes for no fault of the code."""
    result = run(TESTS, "--cpu-times")
    assert result.ret == pytest.ExitCode.OK
    result.assert_outcomes(passed=4)
    advice = "  over 5 s: make it smaller, or mark it slow"
    module = "test_what_tests_cost_is_printed_and_fails_no_run.py"
    result.stdout.fnmatch_lines(
        [
            "*10 tests that cost most*",
            f"100.00 s  {module}::test_marked",
            f"  6.50 s  {module}::test_dear{advice}",
            f"  6.00 s  {module}::test_dear_with_its_fixture{advice}",
            f"  4.50 s  {module}::test_cheap",
        ]
    )


def test_unless_asked_nothing_is_said(run):
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
    result = pytester.runpytest_subprocess(*plugins, "--cpu-times")
    result.assert_outcomes(passed=2)
    cost = re.compile(r"^ *(\S+) s  \S+::test_(begins|ends)", re.MULTILINE)
    costs = {test: float(seconds) for seconds, test in cost.findall(result.stdout.str())}
    assert costs["begins"] > 0.9  # of the processor's time, however long that took
    assert costs["ends"] < 0.9
