"""What every test needs."""

import signal

import pytest

pytest_plugins = ["cpu_time"]  # of tests/support

# A shell that starts something in the background without job control has it ignore interrupts, and
# all its children inherit that: tests that press Ctrl-C would wait for ever.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items):
    """Begin with the tests that take longest: begun last, one would keep a single process busy."""
    items.sort(key=lambda item: item.get_closest_marker("first") is None)


@pytest.fixture
def in_this_process(monkeypatch):
    """Run engines in this process, where a test plants its own, instead of in ones of their own."""
    for module in (
        "ghostball.validation.suite.suite",
        "ghostball.validation.ensembles.run",
        "ghostball.validation.runs.playing",
    ):
        monkeypatch.setattr(f"{module}.limit_of", lambda _: None)


@pytest.fixture
def without_run_figures(monkeypatch):
    """Draw none of the figures of the whole run, for what is about other parts of a report."""
    monkeypatch.setattr("ghostball.reports.report.WHOLE_FIGURES", {})
