"""What every test needs."""

import signal
import sys
from functools import cache
from pathlib import Path

import pytest
import typer.testing
from hypothesis import HealthCheck, settings

from ghostball.engine.library.entry import COMPILED

# For `benchmarks` and `docs`. Last, so that `ghostball` is the one that the tests are run on: the
# wheel's, or a copy with a planted bug.
sys.path.append(str(Path(__file__).parents[1]))

# Hypothesis repeats itself, so that a red test stays red.
settings.register_profile(
    "repeatable",
    deadline=None,  # the first example compiles; without JIT every example is slow
    derandomize=True,
    database=None,
    max_examples=40 if COMPILED else 8,  # the same first ones
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("repeatable")

# Typer creates all commands at each call in a test, which takes longer than most calls.
typer.testing._get_command = cache(typer.testing._get_command)

# A shell that starts something in the background without job control has it ignore interrupts, and
# all its children inherit that: tests that press Ctrl-C would wait for ever.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def in_this_process(monkeypatch):
    """Run engines in this process, where a test plants its own, instead of in ones of their own."""
    monkeypatch.setattr("ghostball.validation.parallel.pool.limit_of", lambda _: None)
    monkeypatch.setattr("ghostball.cli.options.processor_count", lambda: 1)  # `--jobs auto`


@pytest.fixture
def without_run_figures(monkeypatch):
    """Draw no sheets, for what is about other parts."""
    monkeypatch.setattr("ghostball.reports.report.draw_sheet", lambda _: None)
