"""`ghostball diff`: two results folders, or two engines of one folder."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import pytest
from commands import cli, refused
from stored_records import cut_short

from ghostball.validation.baselines.run_pairs import changes_of
from ghostball.validation.results.records import Accuracy, Check
from ghostball.validation.results.store import Results


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Two folders; the second has a longer step, one scene less, and one engine more."""
    place = tmp_path_factory.mktemp("runs")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("ghostball.validation.parallel.pool.limit_of", lambda _: None)
        patch.setattr("ghostball.cli.options.processor_count", lambda: 1)
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
    assert result.stdout.startswith("6 of 6 cases unchanged: a -> a\n")


def test_scenes_of_only_one_side_are_described(here):
    result = cli("diff", "a", "b")
    assert result.exit_code == 0, result.output
    assert "3 of 6 cases unchanged" in result.stdout
    assert "head-on" in result.stdout
    assert "missing: b doesn't contain this case" in result.stdout
    assert "missing: b doesn't contain this case" in cli("diff", "b", "a").stdout


def test_two_engines_of_one_folder_are_compared_scene_by_scene(here):
    engines = ("paper-discrete:dt=1e-3", "paper-discrete:dt=2e-3")
    result = cli("diff", *engines, "--out", "a")
    assert result.exit_code == 0, result.output
    assert "paper-discrete:dt=1e-3 -> paper-discrete:dt=2e-3" in result.stdout
    assert re.search(r"head-on +paper\S+ -> \S+ +worse +[\d.]+ µm -> [\d.]+ µm ", result.stdout)
    plain = json.loads(cli("diff", *engines, "--out", "a", "--format", "json").stdout)
    head_on = next(one for one in plain["cases"] if one["scene"] == "head-on")
    assert (head_on["change"], head_on["failed"]) == ("worse", False)
    assert "rest_error_max" in {one["name"] for one in head_on["metrics"]}
    assert "wall_time" not in {one["name"] for one in head_on["metrics"]}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["a", "none"], "none: not a results folder, but a is one"),
        (["ghostball", "pymonk", "--out", "a"], "pymonk: neither a results folder nor an engine"),
        (
            ["ghostball", "pymunk", "--out", "none"],
            "ghostball: not a results folder, and none, which",
        ),
    ],
)
def test_bad_input_is_refused(here, arguments, said):
    assert refused(cli("diff", *arguments), said)


def test_damaged_results_are_refused(runs, tmp_path):
    cli("validate", "stop", "-e", "ghostball", "--no-report", "--out", tmp_path)
    cut_short(tmp_path)
    assert refused(cli("diff", runs / "a", tmp_path), "is truncated or damaged")


def test_a_worse_class_or_a_failure_only_in_the_second_run_fails(here):
    results = Results.open(here / "a")
    case = results.case("stop", "ghostball")
    held = Check("rest_error_max", 1e-16, "at_most", 1e-12, "m", passed=True, reason="by hand")
    right = replace(case, checks=(held,), accuracy=Accuracy("exact", error=1e-16))
    wrong = replace(right, checks=(replace(held, value=1.0, passed=False),))
    lower = replace(right, accuracy=Accuracy("millimetres", error=2e-3))
    crashed = replace(right, outcome="failed", reason="planted", checks=(), accuracy=None)
    other = replace(right, definition={**right.definition, "t_max": 1.0}, accuracy=lower.accuracy)
    for worse in (wrong, lower, crashed, other):
        fails = [
            changes_of(results, results, [pair])[0].failed
            for pair in ((right, worse), (worse, right), (worse, worse))
        ]
        assert fails == [worse is not other, False, False]
    assert "got 1 m" in changes_of(results, results, [(right, wrong)])[0].broken[0]
