"""Fails where the page says other numbers of generated shots than were found, or hides one."""

from __future__ import annotations

import re

import pytest

from ghostball.reports.page.stress import stress_html
from ghostball.validation.results.store import Results
from ghostball.validation.stress import Size, chosen_shots, run_stress

COARSE = "pymunk:dt=0.05"
SHOTS = ["grazing/rolling-*-1e-0[14]", "tunnelling/speed-*-depth-0.1-phase-0"]


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    """Return the section about a run of a right and a coarse engine, without markup."""
    folder = tmp_path_factory.mktemp("out")
    run_stress(chosen_shots(Size(), SHOTS), ["ghostball", COARSE], folder / "stress")
    html = str(stress_html(Results(folder, [], {})))
    return " ".join(re.sub(r"<[^>]*>", " ", html.replace("<wbr>", "")).split())


def test_it_has_every_count_failure_and_command(shown):
    assert "10 shots on 2 engines" in shown
    assert "not complete" not in shown
    assert re.search(r"Grazing hits and near misses 4/4 3/4", shown)
    assert "collision_count must be == 1, got 0" in shown
    assert f"ghostball stress grazing/rolling-hit-1e-04 -e {COARSE}" in shown


def test_it_says_where_each_engine_begins_to_fail(shown):
    assert re.search(r"depth \[diameters\] 0.0001, 0.1 never ≤ 0.0001", shown)
    assert re.search(r"speed \[m/s\] 2, 160 never always", shown)


def test_results_without_generated_shots_have_no_section(tmp_path):
    assert stress_html(Results(tmp_path, [], {})) == ""
