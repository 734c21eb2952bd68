"""How much the ends of varied starts vary: as cases of the run, beside those of our engine."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result as CliResult

from ghostball.cli import app
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.library import find_scene, select
from ghostball.validation.suite.ensemble import Ensemble, EnsembleError, PerturbationSize
from ghostball.validation.suite.spread import QUANTITIES, spreads_of
from ghostball.validation.suite.suite import run_suite

REST_TIME = "rest time [s]"


def test_varied_starts_are_cases_and_the_scenes_stay_as_they_are(tmp_path: Path) -> None:
    outcome = run_suite(
        select(["stop"]), ["ghostball", "paper-discrete"], tmp_path, ensemble=Ensemble(6)
    )
    assert (outcome.exit_status, len(outcome.cases)) == (ExitStatus.PASSED, 14)
    results = Results.open(tmp_path)
    assert results.scene_names == ["stop"]
    assert [case.scene for case in results.cases] == ["stop", "stop"]
    assert (len(results.varied), results.planned) == (12, 14)
    for case in results.varied:
        assert case.varied_from == "stop"
        assert case.accuracy is None
        assert results.motion(case) is None
        assert {check.metric for check in case.checks} <= {"energy_rise", "overlap_max"}
        assert case.left_out == ()
    ours, stepped = spreads_of(results)
    assert (ours.label, ours.planned, ours.ended, ours.broken) == ("ghostball", 6, 6, 0)
    # By hand: of one ball, whose way is as the square of its speed.
    rest = np.array([c.rest_positions[0] for c in results.varied if c.label == "ghostball"])
    assert ours.position_spread == pytest.approx(math.sqrt(rest.var(axis=0).sum()))
    times = [c.rest_time for c in results.varied if c.label == "ghostball"]
    assert ours.quantities[REST_TIME].mean == pytest.approx(np.mean(times))
    assert ours.quantities[REST_TIME].deviation == pytest.approx(np.std(times, ddof=1))
    assert ours.quantities[REST_TIME].standard_errors is None
    # It steps 20 ms at a time, so that all starts rest at one instant, late.
    assert stepped.quantities[REST_TIME].differs
    assert not stepped.quantities["ball-ball collisions"].differs


def test_they_are_reused_and_more_begin_with_those_of_fewer(tmp_path: Path) -> None:
    engines, scenes = ["paper-discrete"], select(["stop"])
    run_suite(scenes, engines, tmp_path, ensemble=Ensemble(3), reuse=True)
    again = run_suite(scenes, engines, tmp_path, ensemble=Ensemble(4), reuse=True)
    assert again.counts.reused == 4
    alone = run_suite(scenes, engines, tmp_path, reuse=True)
    assert len(alone.cases) == 1
    assert Results.open(tmp_path).varied == []


def test_what_breaks_the_law_from_a_varied_start_fails(tmp_path: Path) -> None:
    """Breaks where varied starts are measured, but not asked what any shot must keep."""
    outcome = run_suite(
        [find_scene("half-ball-cut")],
        ["wrong_engines:Wrong:way=energy"],
        tmp_path,
        ensemble=Ensemble(2),
    )
    assert outcome.exit_status is ExitStatus.CHECK_FAILED
    (spread,) = spreads_of(Results.open(tmp_path))
    assert (spread.ended, spread.broken) == (2, 2)
    assert set(spread.quantities) == set(QUANTITIES)


@pytest.mark.usefixtures("without_run_figures", "in_this_process")
def test_the_command_says_and_reports_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")

    def validate(*more: object) -> CliResult:
        asked = ["validate", "stop", "-eghostball", "-epaper-discrete", "-o", tmp_path / "out"]
        return CliRunner().invoke(app, [str(one) for one in (*asked, *more)])

    result = validate("--ensemble", 6, "--ensemble-size", "velocity=0.01")
    assert result.exit_code == 0, result.output
    for part in ("6 of 6", "velocity=0.01,position=0.0001", "rest time [s]"):
        assert part in result.stdout
    assert "Rest positions from perturbed initial states" in (
        tmp_path / "out/report.html"
    ).read_text("utf-8")
    for wrong, said in (
        (["--ensemble", 1], "at least 2 members"),
        (["--ensemble-size", "velocity=0.01"], "needs --ensemble K"),
        (["--ensemble", 2, "--ensemble-size", "velocity=1"], "must be less than or equal to 0.1"),
    ):
        refused = validate(*wrong)
        assert refused.exit_code == 2
        assert said in " ".join(refused.output.split())


def test_a_size_that_is_too_large_for_a_scene_is_refused_before_anything_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stop: Callable[..., None] = pytest.fail
    monkeypatch.setattr("ghostball.validation.suite.suite.run", stop)
    with pytest.raises(EnsembleError, match="balls could change places"):
        run_suite(
            select(["stop"]),
            ["ghostball"],
            tmp_path,
            ensemble=Ensemble(2, PerturbationSize(velocity=1e-3, position=0.01)),
        )
