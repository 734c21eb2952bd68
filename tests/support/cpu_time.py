"""Plugin of pytest: what each test costs.

`--cpu-times` prints the ten tests that take the most time of the processor, and says of those that
take more than 5 s and aren't marked `slow` that they might be. It is printed, and judges nothing:
how long something takes is the machine's doing too. What counts is the processor's time that passes
while a test runs, of this process and of all that it started, directly or not. What a test sets up
counts as its own, also what later tests share.
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

DEAR = 5.0
"""Processor time beyond which a test might be marked slow [s]."""


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--cpu-times", action="store_true", help="print the tests that cost most")


def pytest_configure(config: pytest.Config) -> None:
    # Workers of xdist measure, and hand what they measured to the process that started them.
    if config.getoption("--cpu-times"):
        config.pluginmanager.register(Meter(), "cpu-meter")
        if not hasattr(config, "workerinput"):
            config.pluginmanager.register(Costs(), "cpu-costs")


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


class Costs:
    """Adds up what each test costs, and prints the most costly."""

    def __init__(self) -> None:
        self.costs: Counter[str] = Counter()  # [s] by test
        self.slow: set[str] = set()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        # A worker that crashed reports a test without it.
        self.costs[report.nodeid] += getattr(report, "cpu_seconds", 0.0)
        if "slow" in report.keywords:
            self.slow.add(report.nodeid)

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        terminalreporter.section(f"{SHOWN} tests that cost most (processor time)")
        for test, cost in self.costs.most_common(SHOWN):
            dear = cost > DEAR and test not in self.slow
            advice = f"  over {DEAR:g} s: make it smaller, or mark it slow" if dear else ""
            terminalreporter.write_line(f"{cost:6.2f} s  {test}{advice}")
