"""`--relations`: which relation an engine breaks, and what could not be judged, by name."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner, Result as CliResult

from ghostball.cli import app
from ghostball.cli.options import RELATION_NAMES
from ghostball.validation.checks.relations import WORDS
from ghostball.validation.results.store import Results

pytestmark = pytest.mark.usefixtures("without_run_figures", "in_this_process")

BIASED = "biased_engines:Biased:way=mirror"


def run(tmp_path: Path, *words: str) -> CliResult:
    return CliRunner().invoke(app, [*words, "-o", str(tmp_path / "out"), "-j", "1"])


@pytest.fixture(autouse=True)
def _wide(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "250")


def test_the_help_names_every_relation() -> None:
    assert tuple(WORDS) == RELATION_NAMES


def test_a_broken_relation_fails_and_the_page_shows_both_runs(tmp_path: Path) -> None:
    found = run(tmp_path, "validate", "half-ball-cut", "-e", BIASED, "--relations")
    assert found.exit_code == 1, found.output
    assert "mirror_factor must be at most 1, got" in found.output
    assert "boost was not judged" in found.output
    (case,) = (one for one in Results.open(tmp_path / "out").cases if one.engine == "biased")
    assert {one.metric for one in case.broken} >= {"mirror_factor"}
    assert "rotate_factor" not in {one.metric for one in case.broken}
    assert case.related["mirror"].first.shape == (2, 3)
    page = (tmp_path / "out/report.html").read_text("utf-8")
    assert "breaks mirror" in page
    assert "Both runs of half-ball-cut" in page


def test_relations_are_asked_only_on_request(tmp_path: Path) -> None:
    found = run(tmp_path, "validate", "half-ball-cut", "-e", "ghostball", "--no-report")
    assert found.exit_code == 0, found.output
    (case,) = Results.open(tmp_path / "out").cases
    assert not case.related


def test_only_the_named_relations_are_asked(tmp_path: Path) -> None:
    words = ("half-ball-cut", "-e", "ghostball", "--no-report", "--relations", "mirror,split")
    found = run(tmp_path, "validate", *words)
    assert found.exit_code == 0, found.output
    (case,) = Results.open(tmp_path / "out").cases
    assert set(case.related) == {"mirror", "split"}


def test_a_named_relation_that_no_scene_can_have_is_not_judged(tmp_path: Path) -> None:
    words = ("half-ball-cut", "-e", "ghostball", "--no-report", "--relations", "boost")
    found = run(tmp_path, "validate", *words)
    assert found.exit_code == 4, found.output
    assert "judged in no case: boost" in found.output


def test_an_unknown_relation_is_refused(tmp_path: Path) -> None:
    found = run(tmp_path, "validate", "stop", "-e", "ghostball", "--relations", "mirror,turn")
    assert found.exit_code == 2, found.output
    assert "must name known relations, got 'turn'" in " ".join(found.output.split())
    assert not (tmp_path / "out").exists()


def test_an_engine_that_refuses_the_second_shot_is_named_and_not_passed(tmp_path: Path) -> None:
    words = ("half-ball-cut", "-e", "biased_engines:Alone", "--no-report")
    found = run(tmp_path, "validate", *words, "--relations", "far-ball")
    assert found.exit_code == 4, found.output
    assert "doesn't support the second shot" in found.output


def test_stress_asks_relations_too(tmp_path: Path) -> None:
    words = ("stress", "grazing/rolling-hit-1e-01", "-e", BIASED, "--relations", "mirror")
    found = run(tmp_path, *words)
    assert found.exit_code == 1, found.output
    assert "1 broken" in found.output
