"""Progress names its steps, counts their parts, and says a time left that is none too sure."""

import io
import re

import pytest
from rich.console import Console

from ghostball.cli.shared import progress
from ghostball.cli.shared.progress import COMPILING, Pace, Steps, counting, in_words


class Clock:
    """Stands still until it is asked to end."""

    now = 100.0

    def __call__(self):
        return self.now


def test_the_time_left_is_that_at_the_pace_so_far():
    clock = Clock()
    pace = Pace(clock)
    pace.done(1, 41)
    assert pace.left() == ""  # timed from here on
    clock.now += 4.0
    pace.done(2, 41)
    assert pace.left() == ""  # too little to know
    clock.now += 16.0
    pace.done(11, 41)
    assert pace.left() == "about 60 s left"  # 2 s each, and 30 to come
    clock.now += 25.0  # of the next part
    assert pace.left() == "about 40 s left"
    clock.now += 40.0
    assert pace.left() == ""  # it takes longer: how long, nobody knows
    pace.done(41, 41)
    assert pace.left() == ""


def test_what_an_earlier_run_did_makes_no_pace():
    clock = Clock()
    pace = Pace(clock)
    pace.done(501, 541)
    clock.now += 40.0
    pace.done(521, 541)
    assert pace.left() == "about 40 s left"


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.0, "a few seconds"), (47.0, "about 50 s"), (130.0, "about 2 min"), (7e3, "about 1.9 h")],
)
def test_a_time_is_said_as_well_as_it_is_known(seconds, words):
    assert in_words(seconds) == words


@pytest.fixture
def logged(monkeypatch):
    """Return what is said where there is no terminal, with no time between two lines."""
    said = []
    monkeypatch.setattr(progress, "LOG_INTERVAL", 0.0)
    monkeypatch.setattr(progress, "say", said.append)
    return said


def test_a_log_names_the_step_and_counts_compilations(logged):
    with Steps(COMPILING, "running").bar() as step:
        compiling, running = step(COMPILING), step("running")
        compiling(0, 5, "")
        compiling(2, 5, "shots")
        running(1, 9, "stop on [a]")
    assert logged == [
        "compiling (step 1 of 2): 0 of 5 done",
        "compiling (step 1 of 2): 2 of 5 done, a few seconds left, last shots",
        r"running (step 2 of 2): 1 of 9 done, last stop on \[a]",
    ]


def test_a_single_step_is_not_counted(logged):
    with counting("measuring") as count:
        count(1, 1, "")
    assert logged == ["measuring: 1 of 1 done"]


def test_a_terminal_shows_step_count_and_part(monkeypatch):
    console = Console(force_terminal=True, width=120, file=io.StringIO())
    monkeypatch.setattr(progress, "stderr", lambda: console)
    with console.capture() as shown, Steps(COMPILING, "running").bar() as step:
        step(COMPILING)(2, 5, "shots")
    text = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", shown.get())
    assert "compiling (step 1 of 2)" in text
    assert "2 of 5" in text
    assert "shots" in text
