"""Counts of breaks beside published ones, and the uncertainty that inputs cause."""

from __future__ import annotations

import pytest

from benchmarks import made_balls as benchmark
from benchmarks.made_balls import CountedBreaks, MadeBallsMeasurement, counted_peers, made_balls
from benchmarks.measurements import measured
from ghostball.validation.measured.breaks import inputs, setups
from ghostball.validation.measured.facts import facts_of

NAME = setups()[0].name


def cell(made: int, impacts: str = "compliant", **changed: float) -> CountedBreaks:
    return CountedBreaks(
        engine="ghostball", setup=NAME, impacts=impacts, changed=changed, breaks=10_000, made=made
    )


def test_the_uncertainty_is_the_root_of_squared_effects_less_that_of_counting():
    cells = [cell(8_000)]
    for k, one in enumerate(inputs()):
        for sign in (-1, 1):
            effect = 400 * (k == 0) - 300 * (k == 1)
            cells.append(cell(8_000 + sign * effect, **{one.name: one.value + sign * one.error}))
    measurement = MadeBallsMeasurement(rounds=1, cells=tuple(cells))
    effects = measurement.effects(NAME, "made")
    assert [effects[one.name][0] for one in inputs()[:3]] == pytest.approx([0.04, -0.03, 0.0])
    counting = sum(error**2 for _, error in effects.values())
    exact = (0.05**2 - counting) ** 0.5
    assert measurement.uncertainty(NAME, "made") == pytest.approx(exact)


def test_shares_leave_scratches_out_where_published_ones_do():
    counts = {"breaks": 100, "made": 80, "clean": 70, "scratch": 15, "eight": 3}
    one = CountedBreaks(engine="ghostball", setup="9-ball", **counts)
    assert one.share("made")[0] == 0.7
    assert one.model_copy(update={"setup": "10-ball"}).share("made")[0] == 0.8
    assert one.model_copy(update={"setup": NAME}).share("scratch")[0] == 0.15


def test_a_small_measurement_has_every_cell_and_is_read_back(tmp_path, monkeypatch):
    monkeypatch.setattr(benchmark, "inputs", lambda: inputs()[:1])
    monkeypatch.setattr(benchmark, "GAPS", benchmark.GAPS[:1])
    found = made_balls(2, ["paper-discrete"])
    assert (
        len(found.compared())
        == found.table.row_count
        == sum(len(facts_of(one).rows) for one in benchmark.FAMILIES.values())
    )
    assert MadeBallsMeasurement.load(found.save(tmp_path)) == found
    assert counted_peers(found) == []
    assert "cushion" in found.cells[-1].detail


def test_facts_have_the_uncertainty_of_inputs_that_was_measured():
    stored = measured(MadeBallsMeasurement)
    for outcome, facts in benchmark.FAMILIES.items():
        for row in facts_of(facts).rows:
            found = stored.uncertainty(row.what, outcome)
            assert (row.inputs or 0.0) == pytest.approx(found, abs=6e-4)
