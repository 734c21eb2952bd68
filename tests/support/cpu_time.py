"""Plugin of pytest: what each test costs, and a run that fails where one costs too much.

`--cpu-limit 5` prints the ten tests that take the most time of the processor, and makes the run
fail if one that isn't marked `slow` takes more than 5 s and more than 1.5 % of what all tests took.
What counts is the processor's time that passes while a test runs, of this process and of all that
it started, directly or not. A busy machine makes a test last longer and costs it little more; a
slow machine makes all tests dearer, so that a share of them says the same on each. What a test sets
up counts as its own, also what later tests share.
"""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

SHOWN = 10
"""Tests that are printed."""

SHARE = 0.015
"""Of what all tests of a run take, one may take this much, however long that is."""

_LIMIT = pytest.StashKey[float]()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--cpu-limit",
        type=float,
        metavar="SECONDS",
        help="print the tests that cost most, and fail if one that isn't marked slow costs more",
    )


def pytest_configure(config: pytest.Config) -> None:
    # Workers of xdist measure, and hand what they measured to the process that started them.
    limit = config.getoption("--cpu-limit")
    if limit is not None:
        config.pluginmanager.register(Meter(), "cpu-meter")
        if not hasattr(config, "workerinput"):
            config.pluginmanager.register(Limit(limit), "cpu-limit")


def used() -> float:
    """Return the processor's time of this process and of all that it started, ended or not [s]."""
    while True:
        ended = _of_ended()
        total = time.process_time() + ended + _of_living("self")
        if _of_ended() == ended:  # none has ended meanwhile, and been left out or counted twice
            return total


def _of_ended() -> float:
    """Return what those took that this process started, and that ended [s]."""
    times = os.times()
    return times.children_user + times.children_system


def _of_living(process: str) -> float:
    """Return what those took that `process` started, and that live, and what they started [s].

    User and system, their own and of theirs that ended. Where the system doesn't tell, nothing.
    """
    total = 0.0
    for task in _listed(f"/proc/{process}/task"):
        for child in _read(f"/proc/{process}/task/{task}/children").split():
            ticks = _read(f"/proc/{child}/stat").rpartition(")")[2].split()[11:15]
            total += sum(map(int, ticks)) / os.sysconf("SC_CLK_TCK") + _of_living(child)
    return total


# Whatever is looked at there may have ended before.
def _listed(folder: str) -> list[str]:
    try:
        return os.listdir(folder)
    except OSError:
        return []


def _read(file: str) -> str:
    try:
        return Path(file).read_text()
    except OSError:
        return ""


class Meter:
    """Measures each phase of each test: what it sets up, the test, what it takes down."""

    def __init__(self) -> None:
        self.before = 0.0  # what had been used when the phase began [s]

    def pytest_runtest_logstart(self) -> None:
        self.before = used()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self) -> Iterator[None]:
        report = yield
        now = used()
        report.cpu_seconds = now - self.before
        self.before = now
        return report


class Limit:
    """Adds up what each test costs, prints the most costly, and judges the run."""

    def __init__(self, limit: float) -> None:
        self.limit = limit  # [s]
        self.costs: Counter[str] = Counter()  # [s] by test
        self.slow: set[str] = set()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        # A worker that crashed reports a test without it.
        self.costs[report.nodeid] += getattr(report, "cpu_seconds", 0.0)
        if "slow" in report.keywords:
            self.slow.add(report.nodeid)

    @property
    def most(self) -> float:
        """What a test of this run may cost [s]."""
        return max(self.limit, SHARE * self.costs.total())

    @property
    def over(self) -> list[str]:
        """Tests that cost more than they may."""
        costs, most = self.costs.items(), self.most
        return [test for test, cost in costs if cost > most and test not in self.slow]

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        if self.over and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        say = terminalreporter
        say.section(f"{SHOWN} tests that cost most (processor time)")
        for test, cost in self.costs.most_common(SHOWN):
            say.write_line(f"{cost:6.2f} s  {test}")
        if not self.over:
            return
        say.section("tests that cost too much", red=True)
        for test in self.over:
            say.write_line(
                f"{test} took {self.costs[test]:.1f} s of the processor, and {self.most:.2g} s is "
                "the most. Make it smaller, or mark it slow; if it compiled kernels, name their "
                "variant in tests/support/compile_kernels.py."
            )
