"""Fails where a terminal shows other figures of real tables, or not how to read them."""

from __future__ import annotations

from likenesses import likeness
from rich.console import Console

from ghostball.cli.measure.verdicts import likeness_table
from ghostball.validation.measured.facts import facts_of
from ghostball.validation.measured.family import Likeness, Measured, families_in

BANKS, REBOUNDS = (
    one for name in ("banks-pool", "cushion-snooker") for one in families_in(facts_of(name))
)


def test_engines_beside_real_tables_come_with_how_to_read_them():
    console = Console(width=120)
    found = [
        likeness("ghostball", rebound=1.5, rolling=0.3),
        likeness("my[x]", rebound="it has none", rolling=1.44),
        likeness("nothing", rebound="no", rolling="no"),
    ]
    with console.capture() as shown:
        console.print(likeness_table(found))
    lines = [line.split() for line in shown.get().splitlines()]
    assert ["ghostball", "1.5", "(1.5)", "0.3", "(0.3)"] in lines
    assert ["my[x]", "–", "1.4", "(1.4)"] in lines
    assert "nothing" not in shown.get()
    assert "standard errors of the measurement, and of what tables differ by" in shown.get()


def said(found: list[Likeness]) -> str:
    console = Console(width=100, record=True)
    console.print(likeness_table(found))
    return " ".join(console.export_text().split())


def test_what_grades_and_what_does_not_are_two_tables():
    bank = Measured(at=1.0, value=2.0, error=0.1, played=2.2)
    rebound = Measured(at=1.0, value=0.9, error=None, played=0.8)
    banks = BANKS.model_copy(update={"figures": (bank,)})
    rebounds = REBOUNDS.model_copy(update={"figures": (rebound,)})
    text = said([Likeness(label="some[engine]", families=(banks, rebounds))])
    graded, shown = text.split("Off what was measured without a known error")
    assert "standard errors of the measurement" in graded
    assert "some[engine] 2.0 (2.0)" in graded
    assert "some[engine] 0.100 m/s" in shown
    assert "bank" not in shown


def test_an_engine_that_lacks_all_has_no_row():
    one = Likeness(label="other", families=(BANKS.lacking("no"), REBOUNDS.lacking("no")))
    assert "other" not in said([one])
