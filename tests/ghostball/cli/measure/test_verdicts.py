"""Fails where the terminal mixes what is off by standard errors with what is off in a unit."""

from __future__ import annotations

from rich.console import Console

from ghostball.cli.measure.verdicts import likeness_table
from ghostball.validation.measured.facts import facts_of
from ghostball.validation.measured.family import Likeness, Measured, family_of

BANKS = family_of(facts_of("banks-pool"), "banks-pool", "bank")
REBOUNDS = family_of(facts_of("cushion-snooker"), "cushion-snooker", "snooker rebound")


def said(found: list[Likeness]) -> str:
    console = Console(width=100, record=True)
    console.print(likeness_table(found))
    return " ".join(console.export_text().split())


def test_what_grades_and_what_does_not_are_two_tables():
    banks = BANKS.played({}, lambda: (Measured(at=1.0, value=2.0, error=0.1, played=2.2),))
    rebounds = REBOUNDS.played({}, lambda: (Measured(at=1.0, value=0.9, error=None, played=0.8),))
    text = said([Likeness(label="some[engine]", families=(banks, rebounds))])
    graded, shown = text.split("Off what was measured without a known error")
    assert "Standard errors off" in graded
    assert "some[engine] 2.0 (2.0)" in graded
    assert "some[engine] 0.100 m/s" in shown
    assert "bank" not in shown


def test_an_engine_that_lacks_all_has_no_row():
    one = Likeness(label="other", families=(BANKS.lacking("no"), REBOUNDS.lacking("no")))
    assert "other" not in said([one])
    assert "engine" in said([])
