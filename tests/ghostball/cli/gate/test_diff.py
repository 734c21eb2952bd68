"""`ghostball diff`: two results folders, or two engines of one."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import pytest
from stored_results import cut_short
from typer.testing import CliRunner

from ghostball.cli import app
from ghostball.validation.checks.difference import difference_of
from ghostball.validation.results.store import Results


def cli(*arguments):
    return CliRunner().invoke(app, [*map(str, arguments)])


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Two folders: the second has a longer step, one scene less, and another engine more."""
    place = tmp_path_factory.mktemp("runs")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("ghostball.validation.parallel.pool.limit_of", lambda _: None)
        patch.setattr("ghostball.cli.shared.options.processor_count", lambda: 1)
        more = ("-e", "paper-discrete:dt=1e-3", "-e", "paper-discrete:dt=2e-3", "--no-report")
        cli("validate", "stop", "head-on", "-e", "ghostball", *more, "--out", place / "a")
        cli("validate", "stop", "-e", "ghostball", *more, "--out", place / "b")
    return place


@pytest.fixture
def here(runs, monkeypatch):
    monkeypatch.chdir(runs)
    monkeypatch.setenv("COLUMNS", "200")
    return runs


def test_the_same_run_twice_is_alike(here):
    result = cli("diff", "a", "a")
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith("6 of 6 cases are alike: a -> a\n")


def test_what_is_only_on_one_side_is_described(here):
    result = cli("diff", "a", "b")
    assert result.exit_code == 0, result.output
    assert "3 of 6 cases are alike" in result.stdout
    assert "head-on" in result.stdout
    assert "not there" in result.stdout
    assert "not there -> " in cli("diff", "b", "a").stdout


def test_two_engines_of_one_folder_are_compared_scene_by_scene(here):
    engines = ("paper-discrete:dt=1e-3", "paper-discrete:dt=2e-3")
    result = cli("diff", *engines, "--out", "a")
    assert result.exit_code == 0, result.output
    assert "paper-discrete:dt=1e-3 -> paper-discrete:dt=2e-3" in result.stdout
    assert re.search(r"head-on +paper\S+ -> \S+ +[\d.]+ µm ✓ -> [\d.]+ µm ✓ ", result.stdout)
    assert "ulps" not in result.stdout
    plain = json.loads(cli("diff", *engines, "--out", "a", "--format", "json").stdout)
    head_on = next(one for one in plain["cases"] if one["scene"] == "head-on")
    assert head_on["differs"]
    assert "rest_error_max" in {one["name"] for one in head_on["metrics"]}
    assert "wall_time" not in {one["name"] for one in head_on["metrics"]}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["a", "none"], "none: no results folder, as a is"),
        (
            ["ghostball", "pymonk", "--out", "a"],
            "pymonk: neither a results folder nor an engine",
        ),
        (["ghostball", "pymunk", "--out", "none"], "none: no such results folder"),
    ],
)
def test_bad_input_is_refused(here, arguments, said):
    result = cli("diff", *arguments)
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    assert said in result.stderr


def test_damaged_results_are_refused(runs, tmp_path):
    cli("validate", "stop", "-e", "ghostball", "--no-report", "--out", tmp_path)
    cut_short(tmp_path)
    result = cli("diff", runs / "a", tmp_path)
    assert result.exit_code == 2, result.output
    assert "is cut short or damaged" in result.stderr


def test_what_fails_in_the_second_alone_got_worse_and_the_other_way_did_not(runs):
    cases = Results.open(runs / "a").cases
    crashed = [replace(cases[0], outcome="failed", reason="planted", checks=()), *cases[1:]]
    worse = difference_of(cases, crashed)
    assert [one.got_worse for one in worse] == [True] + [False] * 5
    assert not any(one.got_worse for one in difference_of(crashed, cases))
    assert [one.got_better for one in difference_of(crashed, cases)] == [True] + [False] * 5


def test_a_class_is_what_counts_first(runs):
    cases = Results.open(runs / "a").cases
    kinds = [case.accuracy.kind for case in cases]
    assert kinds[0] == "exact"
    worse = replace(cases[0], accuracy=replace(cases[0].accuracy, kind="millimetres"))
    found = difference_of(cases[:1], [worse])[0]
    assert (found.got_worse, found.step, found.classes) == (True, -3, ("exact", "millimetres"))
    assert difference_of([worse], cases[:1])[0].got_better


def test_another_shot_of_the_same_name_is_not_compared(runs):
    cases = Results.open(runs / "a").cases
    other = [replace(cases[0], definition={**cases[0].definition, "t_max": 1.0}), *cases[1:]]
    found = difference_of(cases, other)[0]
    assert found.another_shot
    assert found.differs
    assert found.moved == ()
    assert not found.got_worse
