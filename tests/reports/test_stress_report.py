"""Fails where the report of a stress run says other numbers than were found, or hides a break."""

from __future__ import annotations

from dataclasses import replace

import pytest
from stored_results import store_findings

from ghostball.engine import GhostballError
from ghostball.reports import stress_figures, stress_report, style, write_stress_report
from ghostball.reports.stress_figures import (
    draw_cliffs,
    draw_energy_errors,
    draw_equation_of_state,
    draw_miss_rates,
    draw_storms,
)
from ghostball.validation.stress.findings import Finding, StressFolder, StressRun

SCENE = {"schema": 1, "name": "x", "balls": [{"id": "a", "position": [0.0, 0.0, 0.028575]}]}
ENVIRONMENT = {"cpu": "a | b", "date": "2026-01-02T03:04:05+00:00"}


def finding(family, trial, label="ghostball", outcome="survived", **fields):
    faults = ("it | broke",) if outcome == "broken" else ()
    return Finding(family, trial, label, outcome, faults, scene=SCENE, **fields)


def cell(label, speed, depth, missed, misses, largest):
    steps = (1e-3, 1e-2, 1e-1)
    ladder = [{"dt": dt, "missed": n} for dt, n in zip(steps, misses, strict=True)]
    return finding(
        "tunnelling",
        f"speed-{speed:g}-depth-{depth:g}",
        label,
        values={
            "speed": speed,
            "depth": depth,
            "step": 1e-3,
            "missed": missed,
            "ladder": ladder,
            "largest_step": largest,
        },
    )


FOUND = [
    finding("grazing", "hit-1", values={"depth": 1.2e-3, "missed": False}),
    finding("grazing", "hit-2", "pymunk", "broken", shots=4, broken=3, severity=2.0,
            values={"depth": 0.9e-3, "missed": True}),
    finding("grazing", "hit-3", "pymunk", values={"depth": 1e-3, "missed": False}),
    finding("grazing", "miss-1", "pymunk", values={"depth": -1e-9, "missed": False}),
    finding("long-runs", "gas", values={"collisions": 100, "energy_drift": 3e-15,
                                        "curve": [[10, -1e-16], [50, 1e-15]]}),
    finding("long-runs", "state", values={"packing": 0.3, "state": 2.02, "error": 0.01,
                                          "literature": 2.0}),
    finding("storms", "breaks", values={"events": [1, 5, 900], "contact_steps": [0, 0, 7],
                                        "seconds": [1e-4, 2e-4, 0.3]}),
    finding("storms", "breaks", "pymunk", values={"events": [], "contact_steps": [],
                                                  "seconds": []}),
    cell("pymunk", 2.0, 0.1, 0, [0, 1, 2], 1e-3),
    cell("pymunk", 10.0, 0.1, 2, [1, 2, 2], None),
    cell("pymunk:mode=landed", 2.0, 0.1, 0, [0, 0, 0], 1e-1),
    finding("tunnelling", "energy", values={"energy_error": 0.0}),
    finding("tunnelling", "energy", "pymunk",
            values={"energy_error": 1e-4, "dt": 1e-3,
                    "ladder": [{"dt": 1e-2, "energy_error": 1e-3}]}),
]  # fmt: skip


def folder_of(path, findings, planned=None):
    labels = tuple(dict.fromkeys(one.label for one in findings))
    families = tuple(dict.fromkeys(one.family for one in findings))
    missing = (("f", str(k), "ghostball") for k in range((planned or 0) - len(findings)))
    asked = (*(one.key for one in findings), *missing)
    run = StressRun("quick", families, labels, ENVIRONMENT, asked=asked)
    store_findings(path, run, findings)
    return StressFolder.load(path)


@pytest.fixture
def folder(tmp_path):
    return folder_of(tmp_path, FOUND)


@pytest.fixture
def one_figure(monkeypatch):
    """Draw one figure alone: all of them take seconds."""
    figures = {"miss-rate": draw_miss_rates}
    monkeypatch.setattr(stress_report, "FIGURES", figures)
    return figures


def lines_of(axes):
    return {line.get_label(): list(zip(*line.get_data(), strict=True)) for line in axes.lines}


def test_the_report_has_every_count_break_and_command(folder):
    text = write_stress_report(folder.path).read_text()
    assert "| Grazing hits and near misses | 1/1 | **2/3** | – |" in text
    assert "3 of 6" not in text
    assert "| 3 of 4 | `hit-2`: it \\| broke |" in text
    command = f"ghostball run {folder.path}/worst/grazing-pymunk.toml --engine pymunk"
    again = "ghostball stress grazing/hit-2 --engine pymunk --rerun --out "
    assert f"| `{command}` | `{again}{folder.path}-again` |" in text
    assert (folder.path / "worst/grazing-pymunk.toml").exists()
    assert "13 trials of 13" in text
    assert "not whole" not in text
    assert "| `ghostball` | 3 | events | 5 | 882 | 898 | 900 |" in text
    assert "| `pymunk` | 1 ms | 1 ms |" in text
    assert "| `pymunk:mode=landed` | 1 ms | at least 100 ms |" in text
    for name in stress_figures.FIGURES:
        assert f"figures/{name}.svg" in text
        assert (folder.path / f"figures/{name}.png").stat().st_size > 5000


def test_a_run_that_is_not_whole_says_so_and_one_without_breaks_too(tmp_path, one_figure):
    there = folder_of(tmp_path, FOUND[:1], planned=9)
    text = write_stress_report(there.path).read_text()
    assert "1 trial of 9" in text
    assert "not whole" in text
    assert "Nothing broke." in text


def test_what_could_not_be_judged_is_told(tmp_path, one_figure):
    failed = finding("grazing", "hit-9", outcome="failed")
    text = write_stress_report(
        folder_of(tmp_path, [replace(failed, faults=("nothing is proved",))]).path
    ).read_text()
    assert "| **0/0, 1 not judged** |" in text
    assert "| `hit-9`: nothing is proved | `ghostball stress grazing/hit-9 " in text


def test_figures_without_data_are_neither_drawn_nor_left_over(folder, one_figure):
    assert "miss-rate" in write_stress_report(folder.path).read_text()
    folder_of(folder.path, FOUND[4:])
    assert "miss-rate" not in write_stress_report(folder.path).read_text()
    assert list((folder.path / "figures").iterdir()) == []


def test_a_folder_without_a_run_is_refused(tmp_path):
    with pytest.raises(GhostballError, match="not a results folder"):
        write_stress_report(tmp_path)


def test_the_report_is_the_same_each_time(folder, one_figure):
    write_stress_report(folder.path)
    files = [p for p in folder.path.rglob("*") if p.suffix in (".md", ".png", ".svg")]
    before = [path.read_bytes() for path in files]
    write_stress_report(folder.path)
    assert [path.read_bytes() for path in files] == before


def test_miss_rates_are_those_of_each_decade_hits_and_misses_apart(folder):
    with style.drawing():
        hits, misses = draw_miss_rates(folder).axes
    assert lines_of(hits) == {"ghostball": [(1e-3, 0.0)], "pymunk": [(1e-3, 0.5)]}
    assert lines_of(misses) == {"pymunk": [(1e-9, 0.0)]}


def test_energy_errors_stand_at_their_steps_and_collisions(folder):
    with style.drawing():
        steps, collisions = draw_energy_errors(folder).axes
    lines = lines_of(steps)
    assert lines["pymunk"] == [(1e-3, 1e-4), (1e-2, 1e-3)]
    assert {y for _, y in lines["ghostball"]} == {stress_figures.EXACT}  # a level line
    assert lines_of(collisions)["ghostball"] == [(10, 1e-16), (50, 1e-15), (100, 3e-15)]


def test_the_equation_of_state_is_shown_against_the_literature(folder):
    with style.drawing():
        (axes,) = draw_equation_of_state(folder).axes
    (container,) = axes.containers
    assert container.lines[0].get_ydata() == pytest.approx([0.01])


def test_the_part_of_breaks_that_need_as_many_falls_from_one(folder):
    with style.drawing():
        events, contact_steps, _ = draw_storms(folder).axes
    (line,) = events.lines
    assert list(line.get_xdata()) == [1, 5, 900]
    assert list(line.get_ydata()) == pytest.approx([1.0, 2 / 3, 1 / 3])
    assert list(contact_steps.lines[0].get_ydata()) == pytest.approx([1 / 3])


def test_the_cliff_map_has_a_number_in_each_cell_and_frames_misses(folder):
    with style.drawing():
        first, second, *_ = draw_cliffs(folder).axes
    assert [text.get_text() for text in first.texts] == ["1", "none"]
    assert [text.get_text() for text in second.texts] == ["≥ 100"]
    framed = [patch for patch in first.patches if not patch.get_fill()]
    assert len(framed) == 1


@pytest.mark.parametrize("draw", stress_figures.FIGURES.values())
def test_nothing_is_drawn_of_nothing(tmp_path, draw):
    crashed = Finding("storms", "a", "pymunk", "broken", ("the process died",))
    assert draw(folder_of(tmp_path, [crashed])) is None


@pytest.mark.parametrize("count", [1, 2, 4])
def test_nothing_that_is_written_over_the_cliffs_is_cut_off(tmp_path, count):
    labels = ("pymunk", "pymunk:mode=landed", "pybullet", "paper-discrete")[:count]
    found = [cell(one, v, 0.1, 0, [0, 1, 2], 1e-3) for one in labels for v in (2.0, 10.0)]
    with style.drawing():
        figure = draw_cliffs(folder_of(tmp_path, found))
        style.lay_out(figure)
    for text in (figure._supxlabel, figure._suptitle):
        box = text.get_window_extent()
        assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
        assert figure.bbox.y0 <= box.y0 < box.y1 <= figure.bbox.y1
