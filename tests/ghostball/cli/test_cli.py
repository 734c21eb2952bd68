"""The command line: what it prints where, and the exit status of every kind of input."""

import subprocess
import sys

import pytest
from commands import HEAD, ball, refused

from ghostball.cli import PARTS, SECTIONS


@pytest.mark.parametrize("command", [("validate", "stop"), ("stress", "grazing")])
def test_a_cluster_needs_dask(cli, tmp_path, monkeypatch, command):
    monkeypatch.setitem(sys.modules, "distributed", None)
    out = tmp_path / "out"
    result = cli(*command, "--cluster", "tcp://127.0.0.1:8786", "--out", out)
    assert refused(result, "a cluster needs Dask", "pip install '.[cluster]'")
    assert result.stderr.count("\n") == 1
    assert not out.exists()


BAD_SCENES = {
    "unknown key": (HEAD + ball(extra="colour = 3\n"), ["shot.toml:10", "`balls[0].colour`"]),
    "overlap": (HEAD + ball() + ball("object", x="0.55"), ["overlap", '"cue"', "0.00715 m"]),
    "choice": (HEAD + ball() + '[physics]\nmotion = "never"\n', ["`physics.motion`", "'rolling'"]),
    "syntax": ("schema = 1\nname = \n", ["shot.toml:2", "not valid TOML"]),
}
"""One refusal of each kind; every one is in `tests/ghostball/model/scene`."""


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
        (["engines", "--plot", "a.png"], ["only `--steps` runs engines", "Leave out `--plot`"]),
        (["engines", "--steps", "--check"], ["Leave out `--check`"]),
        (["engines", "pymunk", "--check"], ["whole installation", "Leave out `ENGINE`"]),
        (["scenes", "smoke", "--metrics"], ["lists metrics", "Leave out `NAME|TAG`"]),
        (["scenes", "--schema", "--metrics"], ["lists metrics", "Leave out `--schema`"]),
        (["report", "missing"], ["missing", "no such results folder"]),
        (["report", ".", "--export", "a", "--open"], ["writes the tables", "Leave out `--open`"]),
        (["report", "."], ["not a results folder"]),
    ],
)
def test_bad_usage_is_refused_before_anything_is_written(
    cli, tmp_path, monkeypatch, arguments, parts
):
    monkeypatch.chdir(tmp_path)
    assert refused(cli(*arguments), *parts)
    assert list(tmp_path.iterdir()) == []


def test_help_lists_every_command_once_with_its_whole_first_line(cli, monkeypatch):
    # Breaks where a command is in no section, or its first line doesn't fit a terminal.
    monkeypatch.setenv("COLUMNS", "80")
    named = [name for names in SECTIONS.values() for name in names]
    assert sorted(named) == sorted(one.name for part in PARTS for one in part.registered_commands)
    lines = cli("--help").stdout.partition("\nCommands:\n")[2].partition("\n  Exit status")[0]
    listed = [line.split() for line in lines.splitlines() if line.startswith("  ")]
    assert [words[0] for words in listed] == named
    assert {words[-1][-1] for words in listed} == {"."}


def test_help_loads_none_of_the_heavy_packages():
    # Breaks where a module of the command line imports what it calls at its top: help would wait.
    code = (
        "import sys; from ghostball.cli import app; app(['--help'], standalone_mode=False);"
        "print([m for m in ('numpy', 'numba', 'pydantic', 'matplotlib') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
    assert "Exit status: 0 all passed" in done.stdout
