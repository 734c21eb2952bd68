"""The command line: what it prints where, and the exit status of every kind of input."""

import importlib.metadata
import json
import re
import signal
import subprocess
import sys
import time
from importlib import import_module
from inspect import signature
from pathlib import Path
from xml.etree import ElementTree

import pytest
from stored_results import cut_short, in_database
from typer.testing import CliRunner

import ghostball.reference_adapters.pybullet.loading
from ghostball.cli import PARTS, app
from ghostball.reference_adapters import make_engine
from ghostball.reference_adapters.paper.discrete import PaperDiscreteEngine
from ghostball.validation import find_scene, scene_names
from ghostball.validation.results.database import DATABASE, has_database
from ghostball.validation.results.store import Results, has_results

BALL = '[[balls]]\nid = "{id}"\nposition = [{x}, 0.5]\nvelocity = [1.0, 0.0]\n'
HEAD = 'schema = 1\nname = "shot"\n[table]\nlength = 2.0\nwidth = 1.0\n'


def ball(name="cue", x="0.5", extra=""):
    return BALL.format(id=name, x=x) + extra


@pytest.fixture
def cli_with_processes(monkeypatch):
    """Run a command in this process, with lines of a length of its own; its engines in others."""
    monkeypatch.setenv("COLUMNS", "200")

    def run(*arguments):
        result = CliRunner().invoke(app, [str(argument) for argument in arguments])
        assert "\x1b" not in result.output, "control codes without a terminal"
        return result

    return run


@pytest.fixture
def cli(cli_with_processes, in_this_process):
    """Run a command and its engines in this process: to start another one takes a second."""
    return cli_with_processes


def refused(result, *parts):
    """Assert that the input was refused: one message with every part, no traceback, no result."""
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    assert "Traceback" not in result.stderr
    for part in parts:
        assert part in result.stderr
    return True


@pytest.mark.parametrize("command", [("validate", "stop"), ("stress", "grazing")])
def test_a_cluster_needs_dask(cli, tmp_path, monkeypatch, command):
    monkeypatch.setitem(sys.modules, "distributed", None)
    out = tmp_path / "out"
    result = cli(*command, "--cluster", "tcp://127.0.0.1:8786", "--out", out)
    assert refused(result, "a cluster needs Dask", "pip install 'ghostball[cluster]'")
    assert result.stderr.count("\n") == 1
    assert not out.exists()


# --- run --------------------------------------------------------------------------------------


def test_run_shows_rest_positions_counts_energy_work_and_time(cli):
    result = cli("run", "half-ball-cut")
    assert result.exit_code == 0, result.output
    expected = make_engine("ghostball").simulate(find_scene("half-ball-cut"))
    for x, y, _ in expected.rest_positions:
        assert f"{x:.9f}" in result.stdout
        assert f"{y:.9f}" in result.stdout
    for part in ("x [m]", "ball-ball 1, ball-cushion 0", "J at the start", "events 3", "ms"):
        assert part in result.stdout


def test_json_reads_back_to_the_same_bits(cli):
    result = cli("run", "half-ball-cut", "--format=json", "--record", "events")
    assert result.exit_code == 0, result.output
    printed = json.loads(result.stdout)
    expected = make_engine("ghostball").simulate(find_scene("half-ball-cut"), record="events")
    assert printed["rest_positions"] == expected.rest_positions.tolist()
    assert printed["rest_time"] == expected.rest_time
    assert [event["t"] for event in printed["events"]] == expected.events["t"].tolist()
    assert list(printed) == list(expected.to_dict())
    assert result.stdout.count("\n") == 1


def test_plot_writes_a_picture(cli, tmp_path):
    picture = tmp_path / "shot.png"
    result = cli("run", "stop", "--plot", picture)
    assert result.exit_code == 0, result.output
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert str(picture) in result.stdout


def test_a_scene_that_the_engine_cannot_represent_is_refused(cli):
    assert refused(
        cli("run", "sliding-stun", "--engine", "paper-discrete"),
        "`paper-discrete` can't represent",
        "sliding",
        "`ghostball engines` lists which engines can",
    )


# --- bad input --------------------------------------------------------------------------------

BAD_SCENES = {
    "unknown key": (HEAD + ball(extra="colour = 3\n"), ["shot.toml:10", "`balls[0].colour`"]),
    "unknown table": (HEAD + ball() + "[cue]\nangle = 1\n", ["`cue`", "not a known field"]),
    "nan": (HEAD + ball(x="nan"), ["shot.toml:8", "`balls[0].position[0]`", "finite", "nan"]),
    "infinity": (HEAD + ball(extra="mass = inf\n"), ["shot.toml:10", "`balls[0].mass`", "inf"]),
    "overlap": (
        HEAD + ball() + ball("object", x="0.55"),
        ["overlap", '"cue"', '"object"', "0.00715 m"],
    ),
    "outside": (HEAD + ball(x="2.5"), ["`balls[0].position`", "inside", "0.528575 m", "right"]),
    "negative radius": (HEAD + ball(extra="radius = -0.1\n"), ["`balls[0].radius`", "-0.1"]),
    "zero mass": (HEAD + ball(extra="mass = 0.0\n"), ["`balls[0].mass`", "greater than 0"]),
    "restitution": (
        HEAD + ball() + "[physics]\nball_restitution = 1.3\n",
        ["shot.toml:11", "`physics.ball_restitution`", "1.3"],
    ),
    "duplicate id": (HEAD + ball() + ball(x="1.0"), ["`balls[1].id`", "unique", '"cue"']),
    "choice": (HEAD + ball() + '[physics]\nmotion = "never"\n', ["`physics.motion`", "'rolling'"]),
    "type": (HEAD.replace('"shot"', "3") + ball(), ["shot.toml:2", "`name`", "text in quotes"]),
    "missing": (HEAD.replace("width = 1.0\n", "") + ball(), ["`table.width` must be given"]),
    "relation": (HEAD + ball(extra="angular_velocity = [0, 0, 1]\n"), ["that of rolling"]),
    "syntax": ("schema = 1\nname = \n", ["shot.toml:2", "not valid TOML"]),
    "no text": ("schema = 1\n\0", ["shot.toml:2", "not valid TOML"]),
}


@pytest.mark.parametrize("command", ["run", "validate"])
@pytest.mark.parametrize("case", BAD_SCENES)
def test_a_bad_scene_is_refused_before_anything_is_written(
    cli, tmp_path, monkeypatch, case, command
):
    text, parts = BAD_SCENES[case]
    path = tmp_path / "shot.toml"
    path.write_text(text)
    monkeypatch.chdir(tmp_path)
    result = cli(command, path)
    assert refused(result, "shot.toml", *parts)
    assert result.stderr.startswith("error: ")
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["run", "stopp"], ['"stopp"', "Did you mean stop"]),
        (["run", "missing/shot.toml"], ["missing/shot.toml", "No such file"]),
        (["run", "stop", "--engine", "pymonk"], ["'pymonk'", "Did you mean `pymunk`?"]),
        (["run", "stop", "--engine", "ghostball:dt=1"], ["`dt`", "max_events="]),
        (["run", "stop", "--engine", "ghostball:max_events=x"], ["`max_events`", "'x'"]),
        (["run", "stop", "--engine", "ghostball:max_events"], ["`key=value`"]),
        (["run", "stop", "--record", "all"], ["--record", "trajectory"]),
        (
            ["run", "stop", "--record", "rest", "--plot", "a.png"],
            ["needs --record trajectory"],
        ),
        (["run", "stop", "--plot", "a.bmp"], ["'a.bmp'", ".png"]),
        (["run", "stop", "--plot", "missing/a.png"], ["missing/a.png", "No such file"]),
        (["run"], ["SCENE"]),
        (["run", "stop", "--engines", "a"], ["--engines"]),
        (["simulate", "stop"], ["simulate"]),
        (["validate", "smok"], ['"smok"', "smoke"]),
        (["validate", "smo*"], ["matches no shipped scene"]),
        (["validate", "--jobs", "0"], ["--jobs"]),
        (["validate", "stop", "-e", "ghostball", "-e", "pymonk"], ["'pymonk'"]),
        (["validate", "stop", "-e", "ghostball", "-e", ""], ["name must be given"]),
        (["validate", "stop", "-e", "none_such:Engine"], ["`none_such:Engine` can't be imported"]),
        (["validate", "stop", "-e", "pymunk", "-e", "pymunk"], ["once", "pymunk"]),
        (["validate", "stop", "--metric", "rest_eror_max"], ["Did you mean `rest_error_max`"]),
        (["validate", "stop", "--metric", "speed*"], ["'speed*'", "Known: rest_error_max, "]),
        (["validate", "stop", "--metric", ""], ["got ''", "Known: rest_error_max, "]),
        (["validate", "stop", "--format", "xml"], ["--format", "junit"]),
        (["report", "missing"], ["missing", "no such results folder"]),
        (["report", "."], ["not a results folder"]),
    ],
)
def test_bad_usage_is_refused_before_anything_is_written(
    cli, tmp_path, monkeypatch, arguments, parts
):
    monkeypatch.chdir(tmp_path)
    assert refused(cli(*arguments), *parts)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("option", ["--out", "--plot"])
def test_a_place_that_cannot_be_written_is_refused_before_the_run(
    cli, tmp_path, monkeypatch, option
):
    # A parent that is a file: permissions alone would not stop an administrator.
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    target = tmp_path / "file" / "x.png"
    arguments = ["run", "stop"] if option == "--plot" else ["validate", "stop"]
    assert refused(cli(*arguments, option, target), str(target), "Not a directory")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.fixture
def without_pybullet(monkeypatch):
    reason = "pybullet isn't installed. Run `python -m pip install pybullet`"
    monkeypatch.setattr(
        ghostball.reference_adapters.pybullet.loading, "unavailable", lambda: reason
    )


@pytest.mark.usefixtures("without_pybullet")
def test_validate_refuses_an_engine_that_is_asked_for_by_name_and_missing(cli, tmp_path):
    # Breaks where a CI that lost an engine stays green with "0 checks passed".
    out = tmp_path / "out"
    result = cli("validate", "stop", "-e", "ghostball", "-e", "pybullet", "--out", out)
    assert refused(result, "`pybullet` is unavailable", "pip install pybullet")
    assert not out.exists()


@pytest.mark.usefixtures("without_pybullet")
def test_a_missing_optional_engine_is_listed_and_breaks_nothing(cli, tmp_path, monkeypatch):
    listed = cli("engines")
    assert listed.exit_code == 0
    assert "pybullet isn't installed" in listed.stdout
    examined = cli("doctor")
    assert "pip install pybullet" in " ".join(examined.stdout.split())
    assert examined.exit_code == 0, examined.output
    monkeypatch.setattr("ghostball.cli.measure.validate.DEFAULT_ENGINES", ("ghostball", "pybullet"))
    out = tmp_path / "out"
    validated = cli("validate", "stop", "--out", out, "--format", "junit")
    assert validated.exit_code == 0, validated.output
    assert "cases without their engine here: 1" in validated.stderr
    assert "unavailable here" in (out / "report.html").read_text()
    assert "pybullet isn't installed" in validated.stdout
    assert "unavailable" in cli("report", out, "--format", "markdown").stdout


# --- validate, report -------------------------------------------------------------------------


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
def test_a_second_run_reuses_what_is_unchanged_and_says_so(cli, tmp_path):
    command = ("validate", "stop", "-e", "ghostball", "-e", "paper-discrete", "--out", tmp_path)
    first = cli(*command)
    assert first.exit_code == 0, first.output
    assert "reused" not in first.output
    second = cli(*command)
    assert second.exit_code == 0, second.output
    said = f"2 cases unchanged, reused from {tmp_path} (run again with --rerun)"
    assert said in second.stderr
    assert f"{said}; their run times are of then" in second.stdout
    cases = Results.open(tmp_path).cases
    assert all(case.reused for case in cases)
    report = (tmp_path / "report.html").read_text()
    assert "2 of 2 cases reused from an earlier run, since they were unchanged" in report
    assert report.count(f"({cases[0].measured[:10]})") == 4  # beside each run time, in two tables
    third = cli(*command, "--rerun", "--no-report")
    assert "reused" not in third.output
    assert not any(case.reused for case in Results.open(tmp_path).cases)


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
    assert int(passed) + int(left_out) >= every  # of those left out, some have no value here
    report = (tmp_path / "out" / "report.html").read_text()
    said = "Only some metrics were measured</strong>: <code>rest_error_max</code>, "
    assert said in report
    assert f"{left_out} limits on others were not judged" in report
    root = ElementTree.fromstring(result.stdout.encode())
    assert int(root.get("tests")) - int(root.get("skipped")) == int(passed)
    nothing = cli(*command, "--metric", "wall_time", "--no-report")
    assert (
        "nothing was judged: no limit covers what was run. --metric leaves out every limit"
        in nothing.stderr
    )


@pytest.mark.parametrize("damage", ["cut short", "another version", "no database"])
def test_results_that_cannot_be_read_are_one_line_and_stay(cli, tmp_path, damage):
    command = ("validate", "stop", "-e", "paper-discrete", "--out", tmp_path, "--no-report")
    assert cli(*command).exit_code == 0
    path = tmp_path / DATABASE
    if damage == "cut short":
        cut_short(tmp_path)
    elif damage == "another version":
        in_database(tmp_path, "PRAGMA user_version = 1")
    else:
        path.write_text("years of work")
    left = path.read_bytes()
    said = "its version must be" if damage == "another version" else "is cut short or damaged"
    for again in (command, ("report", tmp_path), ("export", tmp_path)):
        assert refused(cli(*again), str(path), said, "Move the file away")
    assert path.read_bytes() == left


def test_export_writes_what_was_found_for_anyone(cli, tmp_path):
    out = tmp_path / "out"
    cli("validate", "stop", "-e", "ghostball", "--out", out, "--no-report")
    result = cli("export", out)
    assert result.exit_code == 0, result.output
    files = [Path(line) for line in result.stdout.splitlines()]
    assert {path.parent for path in files} == {out / "export"}
    assert {"cases.jsonl", "checks.csv", "events.csv"} <= {path.name for path in files}
    assert cli("export", out, "--out", tmp_path / "there").exit_code == 0
    assert (tmp_path / "there" / "metrics.csv").read_text().startswith("scene,label,name,value\n")
    assert refused(cli("export", tmp_path / "none"), "no such results folder")


def test_a_failed_check_of_the_criteria_beside_a_scene_file_fails_the_run(cli, tmp_path):
    # A limit that nothing can meet.
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
    assert "failed  shot on ghostball: ball_cushion_count must be == 77, got" in result.stdout


def test_a_pass_says_whether_its_outcome_was_judged(cli, tmp_path):
    # Breaks where limits that hold, of energy alone, are shown like a right outcome.
    engines = ("-e", "ghostball", "-e", "pymunk:contact_steps=exact", "-e", "paper-discrete")
    out = tmp_path / "out"
    result = cli("validate", "galperin-1", *engines, "--out", out, "--no-report")
    assert result.exit_code == 0, result.output
    row = next(line for line in result.stdout.splitlines() if line.startswith(" galperin-1"))
    cells = [cell.strip() for cell in row.split("  ") if cell.strip()]
    assert cells[1:3] == ["exact ✓", "400 pm ✓"]
    assert cells[3] == "broken: balls 50.9 mm inside each other ≈"
    assert "≈ keeps its limits, of which none is on how the shot ends" in result.stdout


def test_what_an_engine_raises_is_a_fault_of_that_engine(cli, tmp_path, monkeypatch):
    def crash(self, scene, *, record="rest"):
        raise ZeroDivisionError("of the engine")

    monkeypatch.setattr(PaperDiscreteEngine, "simulate", crash)
    result = cli("validate", "stop", "-e", "paper-discrete", "--out", tmp_path, "--no-report")
    assert result.exit_code == 1
    assert (
        "did not finish stop on paper-discrete: ZeroDivisionError: of the engine" in result.stdout
    )
    assert "0 failed, cases that did not finish: 1" in result.stdout
    lines = result.stdout.splitlines()
    (row,) = [line.split() for line in lines if line.startswith(" paper-discrete ")]
    # It finishes one less than it was asked; no error, no time, no limit.
    assert row == ["paper-discrete", "1", "–", "–", "0", "0"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
@pytest.mark.parametrize("option", ["--format=json", "--record=rest"])
def test_a_full_disk_is_said_in_one_line(option):
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "ghostball", "run", "stop", option],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.returncode == 3
    assert done.stderr.startswith("error: standard output: can't be written: No space left")
    assert done.stderr.count("\n") == 1


@pytest.mark.compiled  # interpreted, our engine is too slow to be interrupted at a chosen time
def test_ctrl_c_keeps_what_is_done_and_says_so(tmp_path):
    out = tmp_path / "out"
    names = ["stop", "break-7", "break-8"]
    command = [sys.executable, "-m", "ghostball", "validate", *names, "--out", str(out)]
    # The last case takes minutes, if nobody ends it.
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
    assert f"Interrupted: {done} of {2 * len(names)} cases are done and kept" in stderr
    assert results.state == "interrupted"
    assert "checks passed" in stdout


# --- lists ------------------------------------------------------------------------------------


def test_scenes_lists_every_shipped_scene_with_its_tags(cli):
    result = cli("scenes")
    assert result.exit_code == 0
    for name in scene_names():
        assert f" {name} " in result.stdout
    assert "closed-form" in result.stdout


def test_engines_are_a_table_with_a_line_of_each(cli):
    rows = {
        line.split()[0]: line.split() for line in cli("engines").stdout.splitlines() if line.strip()
    }
    version = importlib.metadata.version("ghostball")
    assert rows["ghostball"][1:] == [version, "yes", "nothing"]
    assert rows["paper-discrete"][1:4] == [version, "yes", "sliding"]  # what most scenes need


def test_engines_lists_settings_and_capabilities(cli):
    result = cli("engines", "ghostball", "pymunk")
    assert result.exit_code == 0
    for part in (
        "ghostball  available",
        "max_events=",
        "contact_steps=fixed (exact)",
        "dt unset",
        "not represented",
        "rolling without slip",
    ):
        assert part in result.stdout


def test_a_broken_foreign_engine_is_named_and_hides_no_other(cli, tmp_path, monkeypatch):
    metadata = tmp_path / "broken_engine-1.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: broken-engine\nVersion: 1\n")
    (metadata / "entry_points.txt").write_text("[ghostball.engines]\nbroken = no_such_module:X\n")
    monkeypatch.syspath_prepend(tmp_path)
    listed = cli("engines")
    assert listed.exit_code == 0
    row, why = (line for line in listed.stdout.splitlines() if line.split()[:1] == ["broken"])
    assert row.split()[1] == "no"
    assert "no_such_module" in why
    assert "broken  unavailable" in cli("engines", "broken", "ghostball").stdout
    examined = cli("doctor")
    assert examined.exit_code == 1
    assert "Something is broken" in examined.stderr


def test_doctor_names_versions_kernels_engines_and_scenes(cli):
    result = cli("doctor")
    assert result.exit_code == 0, result.output
    for part in ("python", "numpy", "kernels", "engine ghostball", f"{len(scene_names())} shipped"):
        assert part in result.stdout


# --- the command itself -----------------------------------------------------------------------


def test_help_loads_none_of_the_heavy_packages():
    # Breaks where a module of the command line imports what it calls at its top: help would wait.
    code = (
        "import sys; from ghostball.cli import app; app(['--help'], standalone_mode=False);"
        "print([m for m in ('numpy', 'numba', 'pydantic', 'matplotlib') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
    assert "Exit status: 0 all passed" in done.stdout


def test_what_a_command_does_takes_its_options():
    # Breaks where an option is given another name, or is not looked at: nothing else checks that.
    for one in (found for part in PARTS for found in part.registered_commands):
        module, function = one.callback.does
        does = getattr(import_module(f"ghostball.cli.{module}"), function)
        assert [*signature(does).parameters] == [*signature(one.callback).parameters]


def test_the_command_is_installed_and_is_the_module():
    command = Path(sys.executable).parent / "ghostball"
    for start in ([str(command)], [sys.executable, "-m", "ghostball"]):
        done = subprocess.run([*start, "--version"], capture_output=True, text=True, check=True)
        assert done.stdout.startswith("ghostball ")


def test_an_unexpected_error_is_short_with_its_traceback_and_status_3(cli, monkeypatch):
    def fail(name):
        raise RuntimeError("disc [bold]error")

    monkeypatch.setattr("ghostball.cli.measure.run.find_scene", fail)
    result = cli("run", "stop")
    assert result.exit_code == 3
    assert result.stdout == ""
    assert "Traceback" in result.stderr
    assert "ghostball itself failed: RuntimeError: disc [bold]error" in result.stderr


def test_ctrl_c_in_any_command_is_status_130(cli, monkeypatch):
    def interrupt(name):
        raise KeyboardInterrupt

    monkeypatch.setattr("ghostball.cli.measure.run.find_scene", interrupt)
    result = cli("run", "stop")
    assert result.exit_code == 130
    assert "Interrupted." in result.stderr
