"""The command line: output, and the exit status for every kind of input."""

import shlex
import subprocess
import sys

import pytest
from commands import HEAD, ball, refused

from ghostball.cli import PARTS, SECTIONS
from ghostball.cli.options import Format


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
"""One rejection of each kind; all of them are in `tests/ghostball/model/scene`."""


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


STILL = 'schema = 1\nname = "still"\n[[balls]]\nid = "a"\nposition = [0.0, 0.0]\n'
TABLE = "--table 2.54 1.27 --radius 0.028575"
FIT = f"fit tracks.csv {TABLE}"
SHOT = "grazing/rolling-hit-1e-01"

BAD_USAGE = [
    ("run stopp", '"stopp"', "Did you mean stop"),
    ("run STOP", '"STOP"', "Did you mean stop"),
    ("run missing/shot.toml", "missing/shot.toml", "No such file"),
    ("run stop --engine pymonk", "'pymonk'", "Did you mean `pymunk`?"),
    ("run stop --engine ghostball:dt=1", "`dt`", "max_events="),
    ("run stop --engine ghostball:max_events=x", "`max_events`", "'x'"),
    ("run stop --engine ghostball:max_events", "`key=value`"),
    ("run stop --record all", "--record", "trajectory"),
    ("run stop --record rest --plot a.png", "needs --record trajectory"),
    ("run stop --plot a.bmp", "'a.bmp'", ".png"),
    ("run stop --plot missing/a.png", "missing/a.png", "No such file"),
    ("run stop --plot tracks.csv/a.png", "tracks.csv/a.png", "Not a directory"),
    ("run stop --expect-hash abc", "must be 64 hexadecimal digits, got 'abc'"),
    (f"run stop --expect-hash {'0' * 64} --record=rest", "needs --record events"),
    ("run sliding-stun -e paper-discrete", "`paper-discrete` can't represent", "sliding"),
    ("run sliding-stun -e paper-discrete", "`ghostball engines` lists what each engine supports"),
    ("run", "SCENE"),
    ("run stop --engines a", "--engines"),
    ("simulate stop", "simulate"),
    ("validate smok", '"smok"', "smoke"),
    ("validate smo*", "matches no shipped scene"),
    ("validate --jobs 0", "--jobs"),
    ("validate stop --out tracks.csv/a", "tracks.csv/a", "Not a directory"),
    ("validate stop -e ghostball -e pymonk", "'pymonk'"),
    ("validate stop -e ghostball -e ''", "name must be given"),
    ("validate stop -e none_such:Engine", "`none_such:Engine` can't be imported"),
    ("validate stop -e pymunk -e pymunk", "once", "pymunk"),
    ("validate stop --metric rest_eror_max", "Did you mean `rest_error_max`"),
    ("validate stop --metric speed*", "'speed*'", "Known: rest_error_max, "),
    ("validate stop --metric ''", "got ''", "Known: rest_error_max, "),
    ("validate stop --format xml", "--format", "junit"),
    ("explain nosuch --engine pymunk", 'unknown scene "nosuch"'),
    ("explain stop --engine pymnk", "Did you mean `pymunk`?"),
    ("explain stop --engine pymunk:dt=-1", "`dt` of engine `pymunk`"),
    ("explain sliding-stun -e paper-discrete", "no sliding that becomes rolling"),
    ("explain stop --engine certified", "`certified` is itself the reference"),
    ("explain mathavan-cut --engine ghostball", "is itself the reference"),
    ("explain still.toml --engine pymunk", "no ball moves"),
    ("explain stop --engine pymunk --plot shot.bmp", "must end in"),
    ("explain stop", "--engine", "no [tool.ghostball] names an engine"),
    ("explain -e pymunk", "holds no result of pymunk"),
    (f"fit tracks.csv {TABLE.replace('.', '')}", "LENGTH must be above 0 and at most"),
    (f"fit tracks.csv {TABLE.replace('0.02', '2')}", "well below the width of the table"),
    (f"{FIT} --fields mass", "can't fit 'mass'. Choose from rolling_friction,"),
    (f"{FIT} --preset felt", "must be one of pool, pool-coulomb, carom, snooker"),
    (f"{FIT} --preset paper", "in which balls slide; got 'paper'"),
    (f"{FIT} --law mirror", "must be one of restitution,"),
    (f"{FIT} --plot left.gif", "must end in"),
    (f"{FIT} --nose-height 36", "must be from a ball's radius, 0.028575, to below"),
    (f"{FIT} --nose-height nan", "must be from a ball's radius, 0.028575, to below"),
    (f"{FIT} --nose-height 0.036 --fields cushion_height", "Remove one"),
    (f"{FIT} --engine nobody", "unknown engine 'nobody'"),
    (f"{FIT} --out nowhere/table.toml", "can't write the file of `--out`"),
    (FIT, "tracks.csv:1: expected the header shot,ball,t,x,y, found 'a,b'"),  # see test_tracks.py
    (f"fit few.csv {TABLE}", "few.csv: not enough data for a fit: 0 stretches"),
    ("stress grasing", "'grasing'"),
    (f"stress {SHOT} -e chess", "chess"),
    (f"stress {SHOT} -e ghostball -e ghostball", "once"),
    (f"stress {SHOT} --jobs 0", "--jobs"),
    (f"stress {SHOT} --count 0", "--count"),
    (f"stress {SHOT} --time-limit 0", "`time_limit`"),
    ("run stop --time-limit -3", "`time_limit`"),
    (f"stress {SHOT} --time-limit soon", "--time-limit"),
    (f"stress {SHOT} --out .", "not a Ghostball results folder"),
    ("regress none-such", "none-such"),
    ("regress stop --baselines tracks.csv", "not a folder"),
    ("regress stop --out tracks.csv", "tracks.csv"),
    ("regress stop --format xml", "--format"),
    ("regress stop --against HEAD --fail-on worse", "--against compares revisions"),
    ("accept", "--reason"),
    ("engines --plot a.png", "only `--steps` runs engines", "Remove `--plot`"),
    ("engines --steps --check", "Remove `--check`"),
    ("engines pymunk --check", "whole installation", "Remove `ENGINE`"),
    ("engines ghostball --recipe", "has no recipe"),
    (
        "engines --recipe",
        "needs an engine: box2d, box2d3, dart, mujoco, newton, physx, pybullet, pymunk",
    ),
    ("engines --steps --scene nosuch", 'unknown scene or tag "nosuch"'),
    ("engines --steps --scene mathavan-cut", '"mathavan-cut" has no reference'),
    ("engines --steps pymunk:dt=-1", "`dt` of engine `pymunk`"),
    ("engines --steps nosuch:simulate", "`nosuch:simulate`"),
    ("engines --steps --repeats 0", "--repeats"),
    ("engines --steps --plot steps.txt", "must end in"),
    ("engines --steps ghostball --plot steps.png", "none of these engines has one"),
    ("engines --steps --out /dev/null/x", "can't create the folder"),
    ("scenes smoke --metrics", "lists metrics", "Remove `NAME|TAG`"),
    ("scenes --schema --metrics", "lists metrics", "Remove `--schema`"),
    ("report missing", "missing", "no such results folder"),
    ("report missing --export here", "no such results folder"),
    ("report . --export a --open", "writes the tables", "Remove `--open`"),
    ("report . --format=json --open", "instead of writing a report"),
    ("report . --format=json --figures=none", "instead of writing a report"),
    ("report . --format=json --jobs=2", "instead of writing a report"),
    ("report .", "not a results folder"),
    *((f"report missing --format {form}", "no such results folder") for form in Format),
    *((f"report . --format {form}", "not a results folder") for form in Format),
    ("init -e pymonk", "pymonk"),
]


@pytest.mark.parametrize(("command", "parts"), [(one[0], one[1:]) for one in BAD_USAGE])
def test_bad_usage_is_refused_before_anything_is_written(cli, here, command, parts):
    (here / "still.toml").write_text(STILL)
    (here / "tracks.csv").write_text("a,b\n")
    (here / "few.csv").write_text("shot,ball,t,x,y\n1,cue,0,1,1\n1,cue,0.02,1,1\n")
    assert refused(cli(*shlex.split(command)), *parts)
    assert {path.name for path in here.iterdir()} == {"still.toml", "tracks.csv", "few.csv"}


def test_help_lists_every_command_once_with_its_whole_first_line(cli, monkeypatch):
    # Every command must be in a section, with a first line that fits a terminal.
    monkeypatch.setenv("COLUMNS", "80")
    named = [name for names in SECTIONS.values() for name in names]
    assert sorted(named) == sorted(one.name for part in PARTS for one in part.registered_commands)
    lines = cli("--help").stdout.partition("\nCommands:\n")[2].partition("\n  Exit status")[0]
    listed = [line.split() for line in lines.splitlines() if line.startswith("  ")]
    assert [words[0] for words in listed] == named
    assert {words[-1][-1] for words in listed} == {"."}


HEAVY = ("numba", "matplotlib", "mpmath", "flint", "sqlite3", "asyncio", "ghostball.engine")


@pytest.mark.parametrize(
    ("command", "without"), [("--help", ("numpy", "pydantic", *HEAVY)), ("scenes", HEAVY)]
)
def test_a_light_command_loads_none_of_the_heavy_packages(command, without):
    # No module may import at its top what this command doesn't need.
    code = (
        f"import sys; from ghostball.cli import app; app([{command!r}], standalone_mode=False);"
        f"print([m for m in {without!r} if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
    said = {"--help": "Exit status: 0 all checks passed", "scenes": "half-ball-cut"}[command]
    assert said in done.stdout
