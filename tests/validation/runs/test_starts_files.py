"""Files of starts and strokes: any division of a file gives equal bits; bad files are refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from commands import cli, refused

from ghostball.engine import simulate
from ghostball.model import GhostballError, Scene
from ghostball.validation.parallel.pool import Done
from ghostball.validation.runs import starts_files
from ghostball.validation.runs.starts_files import Shard, parquet_of, play_file
from ghostball.validation.scenes.library import find_scene

polars = pytest.importorskip("polars")

CUT, DRAW = "half-ball-cut", "draw-shot"


def strokes(count: int) -> dict[str, np.ndarray]:
    chance = np.random.default_rng(1)
    return {"speed": chance.uniform(0.5, 4.0, count), "direction": chance.uniform(-0.1, 0.1, count)}


def written(path: Path, columns: dict) -> Path:
    frame = polars.DataFrame(columns)
    (frame.write_csv if path.suffix == ".csv" else frame.write_parquet)(path)
    return path


@pytest.fixture
def short_parts(monkeypatch):
    monkeypatch.setattr(starts_files, "PART", 7)


@pytest.mark.parametrize("ending", ["csv", "parquet"])
@pytest.mark.parametrize("count", [1, 3, 10])
def test_shards_are_the_whole_cut(tmp_path, short_parts, ending, count):
    scene, file = find_scene(DRAW), written(tmp_path / f"strokes.{ending}", strokes(30))
    whole = play_file(scene, file, Shard(1, 1))
    assert whole["shot"].to_list() == list(range(30))
    parts = [play_file(scene, file, Shard(i, count)) for i in range(1, count + 1)]
    assert polars.concat(parts).equals(whole)
    assert parquet_of(polars.concat(parts)) == parquet_of(whole)


def test_a_row_is_the_shot_with_these_numbers(tmp_path):
    scene = find_scene(CUT)
    cue, other = scene.balls
    columns = {f"{cue.id}.vx": [1.0, 2.0], f"{cue.id}.vy": [0.1, 0.0], f"{other.id}.y": [0.6, 0.61]}
    frame = play_file(scene, written(tmp_path / "starts.csv", columns), Shard(1, 1))
    for k, found in enumerate(frame["rest_positions"].to_list()):
        moved = cue.model_copy(
            update={"velocity": (columns["cue.vx"][k], columns["cue.vy"][k], 0.0)}
        )
        x, _, z = other.position
        balls = [moved, other.model_copy(update={"position": (x, columns[f"{other.id}.y"][k], z)})]
        fields = scene.model_dump(by_alias=True) | {"balls": [one.model_dump() for one in balls]}
        assert found == simulate(Scene.model_validate(fields)).rest_positions.tolist()


def test_spins_are_those_of_the_file_or_of_the_scene(tmp_path):
    scene = find_scene(DRAW)
    spins = scene.angular_velocities[0]
    columns = {f"{scene.balls[0].id}.{name}": [float(scene.velocities[0][0])] for name in ("vx",)}
    columns |= {
        f"{scene.balls[0].id}.w{a}": [w] for a, w in zip("xyz", spins.tolist(), strict=True)
    }
    frame = play_file(scene, written(tmp_path / "starts.parquet", columns), Shard(1, 1))
    (found,) = frame["rest_positions"].to_list()
    assert found == simulate(scene).rest_positions.tolist()


class OtherMachines:
    """A substitute for a cluster: tasks end in reverse order."""

    def __init__(self, crashed: str = "") -> None:
        self.crashed = crashed

    def run_tasks(self, tasks, work, limit=None, prepare=None, kind=None):
        for task in list(tasks)[::-1]:
            yield Done(task, None if self.crashed else work(task), self.crashed, "")


def test_a_cluster_gives_the_same_bits(tmp_path, short_parts):
    scene, file = find_scene(DRAW), written(tmp_path / "strokes.csv", strokes(30))
    there = play_file(scene, file, Shard(2, 2), cluster=OtherMachines())
    assert there.equals(play_file(scene, file, Shard(2, 2)))
    with pytest.raises(GhostballError, match="the shots from 28 on failed: lost"):
        play_file(scene, file, Shard(1, 1), cluster=OtherMachines("lost"))


@pytest.mark.parametrize("text", ["65/64", "0/64", "7", "a/b", "-1/4", "1/0", "1/2/3", "1.5/2"])
def test_shards_that_do_not_exist(text):
    with pytest.raises(GhostballError, match="must be i/n with i from 1 to n, such as 7/64"):
        Shard.parse(text)


def test_every_shot_is_in_one_shard():
    for number in (0, 1, 7, 64, 1000):
        shards = [Shard(k, 7).of(number) for k in range(1, 8)]
        assert [shot for shard in shards for shot in shard] == list(range(number))


BAD = [
    (
        {"speed": [1.0, np.nan], "direction": [0.0, 0.0]},
        "`speed` of shot 1 must be a finite number",
    ),
    ({"speed": [1.0, None], "direction": [0.0, 0.0]}, "`speed` of shot 1 must be a finite number"),
    ({"speed": ["1", "fast"], "direction": [0.0, 0.0]}, "`speed` of shot 1 must be .* got 'fast'"),
    ({"speed": [1.0], "direction": [0.0], "spin": [0.0]}, "`spin` is not a column of starts"),
    ({"speed": [1.0]}, "must include speed and direction"),
    ({"speed": [1.0], "direction": [0.0], "cue.x": [0.5]}, "must include speed and direction"),
    (
        {"speed": [1.0, 1.0], "direction": [0.0, 0.0], "offset_up": [0.0, 2.0]},
        "`strokes` of shot 1: ",
    ),
    ({"cue.x": [0.5, -1.0]}, "in shot 1"),
    ({"speed": [], "direction": []}, "shard 1/1 has no shots"),
]


@pytest.mark.parametrize(("columns", "words"), BAD, ids=range(len(BAD)))
@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_bad_files_name_the_shot(tmp_path, columns, words, ending):
    file = written(tmp_path / f"starts.{ending}", columns)
    with pytest.raises(GhostballError, match=words):
        play_file(find_scene(DRAW), file, Shard(1, 1))


def test_an_error_in_a_later_part_names_the_shot_of_the_file(tmp_path, short_parts):
    columns = strokes(20) | {"offset_up": [0.0] * 18 + [2.0, 0.0]}
    with pytest.raises(GhostballError, match=r"shot 4.*shot 0 here is shot 14 of the file"):
        play_file(find_scene(DRAW), written(tmp_path / "strokes.csv", columns), Shard(1, 1))


@pytest.mark.parametrize("name", ["starts.txt", "starts.csv", "starts.parquet"])
def test_files_that_are_no_tables(tmp_path, name):
    (tmp_path / name).write_bytes(b"\x00PAR1" if "parquet" in name else b"")
    with pytest.raises(GhostballError, match=f"{name} (must be a .csv|can't be read as a table)"):
        play_file(find_scene(CUT), tmp_path / name, Shard(1, 1))


def test_the_command_writes_a_file_for_each_shard(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = written(tmp_path / "strokes.csv", strokes(12))
    for i in (1, 2):
        done = cli("run", DRAW, "--starts", file, "--shard", f"{i}/2", "--format", "json")
        assert done.exit_code == 0
        facts = json.loads(done.stdout)
        assert facts["file"] == f"shots/shots-{i}-of-2.parquet"
        assert facts["shots"] == facts["ended"]["rest"] == 6
    found = polars.read_parquet("shots/*.parquet")
    assert found["shot"].to_list() == list(range(12))
    assert refused(cli("run", DRAW, "--starts", file, "--shard", "65/64"), "got '65/64'")
    assert refused(cli("run", DRAW, "--shard", "1/2"), "the option needs `--starts`")
    assert refused(cli("run", DRAW, "--starts", file, "-e", "pymunk"), "Remove `--engine`")
    assert refused(cli("run", DRAW, "--starts", file, "--out", "strokes.csv"), "can't be written")
