"""Fails where the page says other numbers of a stress run than were found, or hides a break."""

from __future__ import annotations

import re

import pytest
from stored_results import store_findings

from ghostball.reports.page.stress import stress_html
from ghostball.validation.results.store import Results
from ghostball.validation.stress.findings import Finding, StressRun

SCENE = {"schema": 1, "name": "x", "balls": [{"id": "a", "position": [0.0, 0.0, 0.028575]}]}
EVIL = "</script><img src=x onerror=alert(1)>"


def finding(family, trial, label="ghostball", outcome="survived", **fields):
    faults = (EVIL,) if outcome in ("broken", "failed") else ()
    return Finding(family, trial, label, outcome, faults, scene=SCENE, **fields)


FOUND = [
    finding("grazing", "hit-1"),
    finding("grazing", "hit-2", "pymunk", "broken", shots=4, broken=3, severity=2.0),
    finding("grazing", "hit-3", "pymunk"),
    finding("storms", "breaks"),
    finding("tunnelling", "a", "pymunk", values={
        "speed": 2.0, "depth": 0.1, "step": 1e-3, "largest_step": 1e-2,
        "ladder": [{"dt": 1e-3, "missed": 0}, {"dt": 1e-2, "missed": 0}]}),
]  # fmt: skip


@pytest.fixture
def shown(tmp_path):
    """Return the section on what was found, as one line of text without markup."""

    def show(findings, planned=0):
        labels = tuple(dict.fromkeys(one.label for one in findings))
        families = tuple(dict.fromkeys(one.family for one in findings))
        missing = (("f", str(k), "ghostball") for k in range(planned - len(findings)))
        asked = (*(one.key for one in findings), *missing)
        run = StressRun("quick", families, labels, {"cpu": "c", "date": "2026-01-02T"}, asked=asked)
        store_findings(tmp_path / "stress-quick", run, findings)
        html = str(stress_html(Results(tmp_path, [], {})))
        assert "<img" not in html
        return " ".join(re.sub(r"<[^>]*>", " ", html.replace("<wbr>", "")).split())

    return show


def test_it_has_every_count_break_command_and_tracked_number(shown, tmp_path):
    text = shown(FOUND)
    assert "5 trials of 5 on 2 engines, c, 2026-01-02" in text
    assert "not whole" not in text
    assert "Grazing hits and near misses 1/1 1/2" in text
    assert "pymunk 3 of 4 hit-2 : &lt;/script&gt;" in text
    folder = tmp_path / "stress-quick"
    assert f"ghostball run {folder}/worst/grazing-pymunk.toml --engine pymunk" in text
    assert "ghostball stress grazing/hit-2 --engine pymunk --rerun --out " in text
    assert "pymunk 1 ms at least 10 ms" in text
    assert "Random breaks ( storms ) Whatever the break" in text


def test_a_run_that_is_not_whole_says_so_and_one_without_breaks_too(shown):
    text = shown(FOUND[:1], planned=9)
    assert "1 trial of 9" in text
    assert "not whole" in text
    assert "Nothing broke." in text


def test_what_could_not_be_judged_is_reported(shown):
    text = shown([finding("grazing", "hit-9", outcome="failed")])
    assert "0/0, 1 not judged" in text
    assert "hit-9 : &lt;/script&gt;" in text
    assert "ghostball stress grazing/hit-9 " in text
