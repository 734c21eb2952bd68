"""Spreads are shown scene by scene, each number with how sure its difference from ours is."""

import pytest

from ghostball.reports import spread_text
from ghostball.reports.shared_tables import SPREAD_HEADS, spread_remarks, spread_rows
from ghostball.validation.suite.spread import QUANTITIES, SceneSpread, Spread

OURS, NEAR, FAR = Spread(3.0, 0.5), Spread(3.1, 0.5, 1.0), Spread(9.0, 0.5, 12.0)


def of(label, *, ended=5, broken=0, reasons=(), **found):
    spread = None if ended < 2 else 0.012
    return SceneSpread("break", label, 5, ended, broken, reasons, spread, found)


@pytest.fixture
def shown(monkeypatch):
    rest = list(QUANTITIES)[-1]
    found = [
        of("ghostball", **{rest: OURS}),
        of("near", broken=2, **{rest: NEAR}),
        of("far", **{rest: FAR}),
        of("gone", ended=1, reasons=("it hung",)),
    ]
    monkeypatch.setattr(spread_text, "spreads_of", lambda _: iter(found))


@pytest.mark.usefixtures("shown")
def test_a_row_has_a_cell_under_each_heading_and_a_scene_is_named_once():
    rows = list(spread_rows(None))
    assert {len(row) for row in rows} == {len(SPREAD_HEADS)}
    assert [row[0] for row in rows] == ["break", "", "", ""]
    assert [row[-1] for row in rows] == ["3 ± 0.5", "3.1 ± 0.5 (+1.0)", "≠ 9 ± 0.5 (+12.0)", "–"]
    assert [row[2:4] for row in rows[::3]] == [["5 of 5", "12 mm"], ["1 of 5", "–"]]


@pytest.mark.usefixtures("shown")
def test_what_is_wrong_is_said():
    assert list(spread_remarks(None)) == [
        "break on near: 2 starts that end break a limit of every engine",
        "break on gone: 4 starts without an end: it hung",
    ]
