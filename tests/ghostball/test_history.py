"""`ghostball history`: what it prints, and the exit status of every kind of input."""

import json

import pytest
from measured_history import Repository, targets
from typer.testing import CliRunner

from ghostball import _history
from ghostball.cli import app
from ghostball.validation.bench import measurements
from ghostball.validation.bench._observed import Observed
from ghostball.validation.bench.history import Version


@pytest.fixture
def repository(tmp_path, monkeypatch):
    """A checkout with two versions of one machine's targets."""
    monkeypatch.setenv("COLUMNS", "200")
    made = Repository(tmp_path / "checkout")
    for day, seconds in ((1, 40e-6), (2, 20e-6)):
        made.put("box/targets.json", targets(f"{day}" * 40, day, seconds))
        made.commit()
    monkeypatch.setattr(measurements, "CHECKOUT", made.path)
    return made


def history(*arguments):
    return CliRunner().invoke(app, ["history", *map(str, arguments)])


def test_a_table_has_median_spread_and_ratio(repository):
    result = history()
    assert result.exit_code == 0, result.output
    assert "targets on box" in result.stdout
    assert "1111111" in result.stdout
    assert "40 µs (36 µs to 60 µs)" in result.stdout
    assert "20 µs (18 µs to 30 µs) × 0.500" in result.stdout
    assert "347 B =" in result.stdout
    assert result.stderr == ""


@pytest.mark.parametrize(
    ("before", "now", "said"), [(0.0, 0.0, "0 ="), (0.0, 3.0, "3 from 0"), (3.0, 0.0, "0 × 0")]
)
def test_a_counter_that_was_nothing_is_compared_all_the_same(before, now, said):
    versions = tuple(
        Version("box", "c", "r", dirty=False, date="", values={"missing": Observed(value, "1")})
        for value in (before, now)
    )
    assert _history._cell("missing", versions, 1).startswith(said)


def test_only_the_newest_are_tabled_and_it_is_said(repository, monkeypatch):
    monkeypatch.setattr(_history, "MOST_VERSIONS", 1)
    result = history()
    assert "the newest 1 of 2 versions" in result.stdout
    assert "1111111" not in result.stdout
    assert "× 0.500" in result.stdout


def test_json_has_everything(repository):
    content = json.loads(history("targets", "--json", "--quantity", "*/kernel").stdout)
    assert [one["values"]["break/kernel"]["value"] for one in content["versions"]] == [40e-6, 20e-6]
    assert content["cut"] is False
    assert content["left_out"] == []


def test_a_picture_is_drawn(repository, tmp_path):
    result = history("--plot", tmp_path / "h.svg")
    assert result.exit_code == 0, result.output
    assert (tmp_path / "h.svg").read_text().startswith("<?xml")
    assert str(tmp_path / "h.svg") in result.stdout


def test_what_is_left_out_and_a_cut_history_are_told_apart_from_results(repository, tmp_path):
    repository.put("box/targets.json", "{}")
    repository.commit()
    result = history()
    assert result.exit_code == 0
    assert "left out: benchmarks/results/box/targets.json" in result.stderr
    assert "left out" not in result.stdout


def test_a_shallow_clone_is_said(repository, tmp_path, monkeypatch):
    clone = tmp_path / "clone"
    repository.git("clone", "--quiet", "--depth=1", f"file://{repository.path}", str(clone))
    monkeypatch.setattr(measurements, "CHECKOUT", clone)
    result = history()
    assert result.exit_code == 0
    assert "git fetch --unshallow" in result.stderr


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nosuch"], "kind must be one of"),
        (["stress"], "no measurement of `stress`"),
        (["--quantity", "nosuch"], "`--quantity` must match"),
        (["--plot", "h.txt"], "--plot"),
        (["--plot", "/nowhere/h.png"], "can't write"),
    ],
)
def test_bad_input_is_refused(repository, arguments, said):
    result = history(*arguments)
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    assert said in result.stderr
    assert "Traceback" not in result.stderr


def test_no_checkout_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(measurements, "CHECKOUT", tmp_path)
    result = history()
    assert result.exit_code == 2
    assert "is no checkout" in result.stderr
