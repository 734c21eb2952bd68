"""`ghostball fit`: output, files, and messages for bad input."""

from __future__ import annotations

import json
import sys
import tomllib
from functools import partial
from pathlib import Path

import pytest
from commands import refused

from benchmarks.synthetic_tracks import EXAMPLE, EXAMPLE_PHYSICS, write_example
from ghostball.model import Physics

TABLE = ("--table", "2.54", "1.27", "--radius", "0.028575")
SHOTS = 13


@pytest.fixture
def cli(cli):
    return partial(cli, "fit")


@pytest.fixture
def tracks(tmp_path) -> Path:
    """The first shots of the example: enough for the cloth, too few for everything else."""
    lines = EXAMPLE.read_text(encoding="utf-8").splitlines(keepends=True)
    path = tmp_path / "tracks.csv"
    head, body = lines[:2], lines[2:]
    path.write_text("".join([*head, *(line for line in body if int(line.split(",")[0]) < SHOTS)]))
    return path


def test_the_example_tracks_follow_from_the_example_physics(tmp_path):
    write_example(tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_text() == EXAMPLE.read_text(encoding="utf-8")


def test_the_cloth_alone_of_a_few_shots(cli, tracks, tmp_path):
    out, picture = tmp_path / "table.toml", tmp_path / "left.png"
    found = cli(tracks, *TABLE, "--fields", "rolling_friction", "--out", out, "--plot", picture)
    assert found.exit_code == 0, found.output
    for part in ("rolling_friction", "standard error", "tracker noise: 1 mm", "goodness"):
        assert part in found.stdout
    assert "[physics]" not in found.stdout  # the table is in the file
    assert f"written to {out}\ndrawn in {picture}" in found.stdout
    physics = Physics(**tomllib.loads(out.read_text())["physics"])
    true = EXAMPLE_PHYSICS.rolling_friction
    assert physics.rolling_friction == pytest.approx(true, rel=0.1)
    assert "# +- " in out.read_text()
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_json_is_one_object_with_what_is_not_told(cli, tracks):
    found = cli(tracks, *TABLE, "--format=json")
    assert found.exit_code == 0, found.output
    data = json.loads(found.stdout)
    assert set(data["physics"]["rolling_friction"]) == {"value", "error"}
    assert data["law"] in {"han2005", "mathavan2010", "frictional", "restitution"}
    assert data["events"]["rolling"] > 8
    assert data["goodness"] > 0.0
    assert isinstance(data["not_told_apart"], list)
    assert "ball_restitution" in data["not_told"]


def test_a_fit_without_scipy_says_how_to_get_it(cli, tracks, monkeypatch):
    needs_it = ("scipy", "ghostball.validation.measured.fit", "ghostball.cli.measure.fit")
    for name in [one for one in sys.modules if one.startswith(needs_it)]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "scipy", None)
    found = cli(tracks, *TABLE)
    assert found.exit_code == 2
    assert "pip install '.[fit]'" in found.stderr


def test_tracks_of_another_tracker_give_the_same_fit(cli, tracks, tmp_path):
    other, (length, width) = tmp_path / "other.csv", map(float, TABLE[1:3])
    rows = ["frame,time,x,y,ball,trial"]
    for line in tracks.read_text().splitlines()[2:]:
        shot, ball, t, x, y = line.split(",")
        place = f"{float(x) - length / 2:.6f},{float(y) - width / 2:.6f}"
        rows.append(f"0,{t},{place},{ball},{shot}")
    other.write_text("\n".join(rows))
    asked = (*TABLE, "--fields", "rolling_friction", "--format=json")
    one = json.loads(cli(tracks, *asked).stdout)["physics"]["rolling_friction"]
    names = ("--columns", "t=time, shot=trial", "--origin", "centre")
    two = json.loads(cli(other, *asked, *names).stdout)["physics"]["rolling_friction"]
    assert two == pytest.approx(one, rel=1e-6)


@pytest.mark.parametrize("text", ["t", "t=", "time=t", "t=a,t=b", ""])
def test_a_wrong_map_of_columns_is_refused(cli, tracks, text):
    assert refused(cli(tracks, *TABLE, "--columns", text), "must give a column for some of shot")
