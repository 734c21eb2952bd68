"""Progress names its steps, counts their parts, and says how much time is left."""

import io
import re

import pytest
from rich.console import Console
from rich.progress import Progress

from ghostball.cli.shared import progress
from ghostball.cli.shared.progress import COMPILING, RUNNING, Steps, counting


@pytest.fixture
def logged(monkeypatch):
    """Return the lines printed without a terminal, with no time between two lines."""
    said, seconds = [], iter(range(0, 1000, 4))
    console = Console(file=io.StringIO())
    monkeypatch.setattr(progress, "LOG_INTERVAL", 0.0)
    monkeypatch.setattr(progress, "say", said.append)
    monkeypatch.setattr(progress, "stderr", lambda: console)
    bar = Progress.__init__

    def init(self, *columns, **options):
        bar(self, *columns, get_time=lambda: float(next(seconds)), **options)

    monkeypatch.setattr(Progress, "__init__", init)
    return said


def test_a_log_names_the_step_counts_parts_and_says_the_time_left(logged):
    # Cases of an earlier run, or of another step, must not affect the speed.
    with Steps(COMPILING, RUNNING).bar() as step:
        compiling, running = step(COMPILING), step(RUNNING)
        compiling(0, 5, "")
        compiling(2, 5, "shots")
        running(501, 541, "stop on [a]")
        running(521, 541, "")
    assert logged[:3] == [
        "compiling (step 1 of 2): 0 of 5 done, takes a few minutes, once",
        "compiling (step 1 of 2): 2 of 5 done, takes a few minutes, once, last shots",
        r"running (step 2 of 2): 501 of 541 done, last stop on \[a]",
    ]
    assert re.fullmatch(r"running \(step 2 of 2\): 521 of 541 done, 0:00:0[1-9] left", logged[3])


def test_a_single_step_is_not_counted(logged):
    with counting("measuring") as count:
        count(1, 1, "")
    assert logged == ["measuring: 1 of 1 done"]


def test_a_terminal_shows_step_count_and_part(monkeypatch):
    console = Console(force_terminal=True, width=120, file=io.StringIO())
    monkeypatch.setattr(progress, "stderr", lambda: console)
    with console.capture() as shown, Steps(COMPILING, RUNNING).bar() as step:
        step(COMPILING)(2, 5, "shots")
    text = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", shown.get())
    assert "compiling (step 1 of 2)" in text
    assert "2 of 5" in text
    assert "shots" in text


def test_compiling_promises_no_time_left(monkeypatch):
    # The bar must not say "20 s left" for minutes: the last kernel takes longest.
    console = Console(force_terminal=True, width=160, file=io.StringIO())
    monkeypatch.setattr(progress, "stderr", lambda: console)
    with console.capture() as shown, Steps(COMPILING, RUNNING).bar() as step:
        step(COMPILING)(2, 5, "shots")
        step(RUNNING)(1, 5, "stop")
    text = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", shown.get())
    compiling = [
        line for line in re.split(r"[\r\n]", text) if "compiling" in line and "2 of 5" in line
    ]
    assert all("takes a few minutes, once" in line and "left" not in line for line in compiling)
    assert "left: " in text.rpartition("running")[2]


def test_a_log_says_at_once_that_compiling_begins(logged, monkeypatch):
    monkeypatch.setattr(progress, "LOG_INTERVAL", 1e9)
    with Steps(COMPILING, RUNNING).bar() as step:
        step(COMPILING)(0, 5, "")
        step(RUNNING)(0, 5, "")
    assert logged == ["compiling (step 1 of 2): 0 of 5 done, takes a few minutes, once"]
