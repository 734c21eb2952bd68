"""Engines compared with real tables: the comparison is stored, read back and reused."""

from __future__ import annotations

import sqlite3
from contextlib import closing

import pytest
from table_agreements import keep_likenesses, likeness

from ghostball.validation.results.database import DATABASE
from ghostball.validation.results.store import ResultsError
from ghostball.validation.suite import real_tables
from ghostball.validation.suite.real_tables import load_agreements, measure_agreements

OURS = ("ghostball", "paper-discrete")
RAISING = "faulty_engine:FaultyEngine:does=raise"


def measure(specs, folder, **options):
    return list(measure_agreements(specs, folder, 60.0, **options).records.values())


@pytest.fixture
def measured(monkeypatch):
    """Return the list of engines that are measured from now on."""
    labels = []
    real = real_tables.agreement_with_tables

    def listing(label, *rest):
        labels.append(label)
        return real(label, *rest)

    monkeypatch.setattr(real_tables, "agreement_with_tables", listing)
    return labels


def test_what_is_measured_is_read_back_until_a_run_measures_none(tmp_path):
    specs = ("ghostball", "pymunk:contact_steps=exact", "paper-discrete")
    found = measure(specs, tmp_path)
    assert [one.label for one in found] == list(specs)
    assert load_agreements(tmp_path) == found
    assert measure((), tmp_path) == []
    assert load_agreements(tmp_path) == []
    assert load_agreements(tmp_path / "nowhere") == []


def test_what_is_unchanged_is_reused(tmp_path, measured, monkeypatch):
    first = measure(OURS, tmp_path)
    assert measure(OURS[::-1], tmp_path, reuse=True) == first[::-1]
    assert measured == list(OURS)
    measure(OURS[:1], tmp_path)
    assert measured == [*OURS, "ghostball"]
    # Other measurements, or other best settings.
    monkeypatch.setattr(real_tables, "_known", lambda: ["another"])
    measure(OURS[:1], tmp_path, reuse=True)
    assert measured == [*OURS, "ghostball", "ghostball"]


def test_an_engine_that_fails_costs_its_own_figures_and_is_measured_again(tmp_path, measured):
    for _ in range(2):
        (one,) = measure([RAISING], tmp_path, reuse=True)
        failed = [family for family in one.families if family.failed]
        assert {"cushion", "cushion-slope", "rolling-pool", "banks-pool"} <= {
            family.name for family in failed
        }
        assert all("RuntimeError: lost the balls" in family.lacks for family in failed)
    assert measured == [RAISING, RAISING]


def test_an_interrupt_keeps_what_is_done(tmp_path, measured, monkeypatch):
    real = real_tables.agreement_with_tables

    def interrupting(label, *rest):
        if label == "paper-discrete":
            raise KeyboardInterrupt
        return real(label, *rest)

    with monkeypatch.context() as patch:
        patch.setattr(real_tables, "agreement_with_tables", interrupting)
        ran = measure_agreements(OURS, tmp_path, 60.0)
    assert ran.interrupted
    assert list(ran.records.values()) == load_agreements(tmp_path)
    assert [one.label for one in load_agreements(tmp_path)] == ["ghostball"]
    measure(OURS, tmp_path, reuse=True)
    assert measured == list(OURS)


def test_what_is_damaged_is_refused_by_name(tmp_path):
    measure(OURS[1:], tmp_path)
    with closing(sqlite3.connect(tmp_path / DATABASE)) as database:
        database.execute("""UPDATE records SET record = '{"label": "ghostball"}'""")
        database.commit()
    with pytest.raises(ResultsError, match=r"comparisons with measured tables.*families"):
        load_agreements(tmp_path)


def test_engines_of_different_families_are_refused(tmp_path):
    found = [likeness("ghostball", rebound=1.0, rolling=1.0), likeness("pymunk", rebound=1.0)]
    keep_likenesses(tmp_path, found)
    with pytest.raises(ResultsError, match="engines have different families"):
        load_agreements(tmp_path)
