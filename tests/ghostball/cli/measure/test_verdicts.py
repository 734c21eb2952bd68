"""Fails where a terminal shows other figures of real tables, or not how to read them."""

from __future__ import annotations

from likenesses import likeness
from rich.console import Console

from ghostball.cli.measure.verdicts import likeness_table


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
    assert "standard errors of the measurement: what is below 2 is within" in shown.get()
