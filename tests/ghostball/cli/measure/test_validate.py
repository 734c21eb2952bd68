"""`ghostball validate`: plans, runs, reuse and output."""

from __future__ import annotations

import csv
import json
import re
import signal
import subprocess
import sys
import time
from xml.etree import ElementTree

import pytest
from commands import HEAD, ball, refused

from ghostball.cli.measure.commands import ValidateOptions
from ghostball.cli.measure.validate import _plan
from ghostball.reference_adapters.paper.discrete import PaperDiscreteEngine
from ghostball.reports.style import format_length
from ghostball.validation.results.database import has_database
from ghostball.validation.results.store import Results, has_results
from ghostball.validation.results.tables import export, rows_of


@pytest.mark.parametrize(
    ("scenes", "metrics", "whole"),
    [
        ((), (), True),
        (("full",), (), True),  # as `make validate` asks
        (("stop", "full"), (), True),
        (("stop",), (), False),
        (("full",), ("energy_drift",), False),
    ],
)
def test_engines_are_put_beside_real_tables_where_all_scenes_are_asked(scenes, metrics, whole):
    assert _plan(ValidateOptions(scenes=scenes, metric=metrics)).whole == whole


@pytest.mark.usefixtures("without_pybullet")
def test_validate_refuses_an_engine_that_is_asked_for_by_name_and_missing(cli, tmp_path):
    # A CI run without its engine must not be green with "0 checks passed".
    out = tmp_path / "out"
    result = cli("validate", "stop", "-e", "ghostball", "-e", "pybullet", "--out", out)
    assert refused(result, "`pybullet` is unavailable", "pip install pybullet")
    assert not out.exists()


@pytest.mark.usefixtures("without_pybullet")
def test_the_first_line_of_a_run_names_a_default_engine_that_is_missing(cli, tmp_path):
    result = cli("validate", "stop", "--no-report", "--out", tmp_path / "out")
    first = result.stderr.splitlines()[0]
    assert first.startswith("Default engine `pybullet` was not run: pybullet isn't")
    assert "Run `python -m pip install pybullet`" in first


def test_validate_writes_results_verdicts_and_junit(cli_with_processes, tmp_path):
    out = tmp_path / "results"
    result = cli_with_processes(
        "validate",
        "stop",
        "head-on",
        "-e",
        "ghostball",
        "-e",
        "paper-discrete:dt=1e-2,max_time=60",
        "--out",
        out,
        "--format=junit",
        "--jobs=1",
        "--no-report",
    )
    assert result.exit_code == 0, result.output
    labels = [case.label for case in Results.open(out).cases]
    assert labels == ["ghostball", "paper-discrete:dt=1e-2,max_time=60"] * 2
    for part in ("stop", "head-on", "paper-discrete:dt=1e-2,max_time=60", "checks passed"):
        assert part in result.stderr
    assert not (out / "report.html").exists()
    assert len(ElementTree.fromstring(result.stdout.encode()).findall("testsuite")) == 2
    assert "running (step 2 of 2): 4 of 4 done" in result.stderr


@pytest.mark.usefixtures("without_run_figures")
def test_the_engines_table_counts_scenes_in_which_ghostball_is_the_reference(cli, tmp_path):
    scenes = ("stop", "cushion-mathavan")
    result = cli("validate", *scenes, "-e", "ghostball", "--no-report", "--out", tmp_path / "out")
    assert re.search(r"engine +exact +reference +error", result.stdout)
    assert re.search(r"ghostball +1 +1 +rounding", result.stdout)
    assert "reference: used as the reference for the other engines" in result.stdout


def test_a_second_run_reuses_unchanged_cases_and_says_so(cli, tmp_path):
    command = ("validate", "stop", "-e", "ghostball", "-e", "paper-discrete", "--out", tmp_path)
    first = cli(*command)
    assert first.exit_code == 0, first.output
    assert "reused" not in first.output
    second = cli(*command)
    assert second.exit_code == 0, second.output
    said = f"2 cases reused from {tmp_path} (--rerun runs them again)"
    assert said in second.stderr
    assert f"{said}; their run times are from that run" in second.stdout
    cases = Results.open(tmp_path).cases
    assert all(case.reused for case in cases)
    report = (tmp_path / "report.html").read_text()
    assert "2 of 2 cases reused from an earlier run (" in report
    assert report.count(f"({cases[0].measured[:10]})") == 4  # beside each run time, in two tables
    third = cli(*command, "--rerun", "--no-report")
    assert "reused" not in third.output
    assert not any(case.reused for case in Results.open(tmp_path).cases)


def test_details_show_rest_positions_collisions_and_energy_as_the_files_hold_them(cli, tmp_path):
    command = ("validate", "half-ball-cut", "-e", "pymunk:dt=1e-3", "--out", tmp_path)
    shown = cli(*command, "--no-report", "--details").stdout
    (row,) = rows_of(tmp_path, "comparisons")
    assert (row["rest_ball"], row["ball_ball_count"], row["ball_ball_count_true"]) == (
        "object",
        1,
        1,
    )
    length, share = format_length(row["rest_error"]), f"{row['energy_difference']:.3g}"
    when = f"{row['energy_difference_time']:.4g} s"
    (line,) = [one for one in shown.splitlines() if "object" in one]
    assert line.split() == [
        *("half-ball-cut", "pymunk:dt=1e-3", *length.split(), "object"),
        *("1", "/", "1", "0", "/", "0", share, *when.split()),
    ]
    printed = cli(*command, "--no-report", "--format=json").stdout
    assert json.loads(printed)["comparisons"] == [row]
    export(tmp_path, tmp_path / "files")
    with (tmp_path / "files" / "comparisons.csv").open(encoding="utf-8") as file:
        (stored,) = csv.DictReader(file)
    assert float(stored["rest_error"]) == row["rest_error"]
    printed = cli(*command, "--no-report", "--format=csv").stdout
    assert printed == (tmp_path / "files" / "comparisons.csv").read_text("utf-8")
    page = cli(*command).output and (tmp_path / "report.html").read_text("utf-8")
    assert f"<td>{length}<td>object<td>1 / 1<td>0 / 0<td>{share}<td>{when}" in page


@pytest.mark.usefixtures("without_run_figures")
def test_only_the_metrics_asked_for_are_judged_and_the_others_counted(cli, tmp_path):
    command = ("validate", "stop", "-e", "ghostball", "--out", tmp_path / "out")
    whole = cli(*command, "--no-report").stdout
    every = int(re.search(r"(\d+) checks passed", whole)[1])
    result = cli(*command, "--metric=rest_error_*", "--metric=wall_time", "--format=junit")
    assert result.exit_code == 0, result.output
    passed, left_out = re.search(
        r"(\d+) checks passed, 0 failed, (\d+) left out by --metric", result.stderr
    ).groups()
    assert 0 < int(passed) < every
    assert int(passed) + int(left_out) >= every  # some limits that were left out have no value here
    report = (tmp_path / "out" / "report.html").read_text()
    said = "Only some metrics were measured</strong>: <code>rest_error_max</code>, "
    assert said in report
    assert f"{left_out} limits on other metrics were not checked" in report
    root = ElementTree.fromstring(result.stdout.encode())
    assert int(root.get("tests")) - int(root.get("skipped")) == int(passed)
    nothing = cli(*command, "--metric", "wall_time", "--no-report")
    assert "nothing was judged: no limit applies. --metric leaves out every limit" in nothing.stderr


def test_a_failed_check_of_the_criteria_beside_a_scene_file_fails_the_run(cli, tmp_path):
    # An impossible limit.
    path = tmp_path / "shot.toml"
    path.write_text(HEAD + ball())
    criteria = tmp_path / "shot.expect.toml"
    criteria.write_text(
        '[[criteria]]\nengines = ["ghostball"]\nmetric = "ball_cushion_count"\nequals = 77\n'
        'reason = "none"\n'
    )
    out = tmp_path / "out"
    result = cli("validate", path, "-e", "ghostball", "--out", out, "--no-report")
    assert result.exit_code == 1, result.output
    assert "failed  shot on ghostball: ball_cushion_count must be exactly 77, got" in result.stdout


def test_a_pass_says_whether_its_outcome_was_judged(cli, tmp_path):
    # Passed limits on energy alone must not look like right final positions.
    engines = ("-e", "ghostball", "-e", "pymunk:contact_steps=exact", "-e", "paper-discrete")
    out = tmp_path / "out"
    result = cli("validate", "galperin-1", *engines, "--out", out, "--no-report")
    assert result.exit_code == 4, result.output
    assert "no case of paper-discrete had its final positions judged" in result.stderr
    row = next(line for line in result.stdout.splitlines() if line.startswith(" galperin-1"))
    cells = [cell.strip() for cell in row.split("  ") if cell.strip()]
    assert cells[1:3] == ["exact ✓", "400 pm ✓"]
    assert cells[3] == "unphysical: balls overlap by 50.9 mm ≈"
    assert "≈ passed, but no limit judges the final positions" in result.stdout


def test_an_exception_of_an_engine_is_a_fault_of_that_engine(cli, tmp_path, monkeypatch):
    def crash(self, scene, *, record="rest"):
        raise ZeroDivisionError("of the engine")

    monkeypatch.setattr(PaperDiscreteEngine, "simulate", crash)
    result = cli("validate", "stop", "-e", "paper-discrete", "--out", tmp_path, "--no-report")
    assert result.exit_code == 1
    assert (
        "did not finish stop on paper-discrete: ZeroDivisionError: of the engine" in result.stdout
    )
    assert "0 failed, 1 case did not finish" in result.stdout
    lines = result.stdout.splitlines()
    (row,) = [line.split() for line in lines if line.startswith(" paper-discrete ")]
    # One run fewer than requested finishes; no error, no time, no limit.
    assert row == ["paper-discrete", "1", "–", "–", "0", "0"]


@pytest.mark.compiled  # interpreted, our engine is too slow to be interrupted at a chosen time
def test_ctrl_c_keeps_finished_cases_and_says_so(tmp_path):
    out = tmp_path / "out"
    names = ["stop", "break-7", "break-8"]
    command = [sys.executable, "-m", "ghostball", "validate", *names, "--out", str(out)]
    # The last case would take minutes.
    command += ["-e", "ghostball", "-e", "paper-discrete:dt=1e-6,max_time=600"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        give_up = time.monotonic() + 120
        while not (has_database(out) and has_results(out) and Results.open(out).cases):
            assert process.poll() is None, process.communicate()
            assert time.monotonic() < give_up
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        stdout, stderr = process.communicate(timeout=300)
    assert process.returncode == 130, stderr
    results = Results.open(out)
    done = len(results.cases)
    assert f"Interrupted: {done} of {2 * len(names)} cases are done and stored" in stderr
    assert results.state == "interrupted"
    assert "checks passed" in stdout
