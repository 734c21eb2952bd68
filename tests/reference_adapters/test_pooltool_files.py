"""Files of pooltool are read and written, and the real package simulates them equally."""

from __future__ import annotations

import json
import math
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import GhostballError, Scene
from ghostball.reference_adapters.pooltool_files import load_pooltool, pooltool_json
from ghostball.reference_adapters.workers.process import interpreter
from ghostball.validation.scenes.library import find_scene

SAVED = Path(__file__).with_name("pooltool-0.6.0.json")
"""`pooltool.System.example().save(...)` of pooltool 0.6.0."""

PLAYED = """
import json, sys
import pooltool as pt
from pooltool.physics.engine import PhysicsEngine
from pooltool.physics.resolve.resolver import default_resolver
for path in sys.argv[1:]:
    system = pt.System.load(path)
    pt.simulate(system, engine=PhysicsEngine(resolver=default_resolver()), inplace=True)
    print(json.dumps([ball.state.rvw[0].tolist() for ball in system.balls.values()]))
"""
"""Program that simulates files with pooltool and its default laws."""


def example() -> dict:
    return json.loads(SAVED.read_text())


@pytest.fixture
def load(tmp_path):
    def read(system: dict) -> Scene:
        path = tmp_path / "shot.json"
        path.write_text(json.dumps(system))
        return load_pooltool(path)

    return read


def test_a_saved_shot_is_read():
    scene = load_pooltool(SAVED)
    assert (scene.table.length, scene.table.width) == (1.9812, 0.9906)
    assert scene.physics.cushion == "stronge2000"
    assert scene.physics.spinning_friction_rate == pytest.approx(10.9)
    # The specification of pooltool's table: widths, angles in degrees, and depths from the corner.
    corner, side = scene.table.pockets.corner, scene.table.pockets.side
    assert corner.mouth == pytest.approx(0.118)
    assert math.degrees(corner.angle) == pytest.approx(90.0 + 45.0 + 5.3)
    assert corner.depth == pytest.approx(0.0417 + 0.118 / 2 - 0.062)
    assert side.mouth == pytest.approx(0.137)
    assert math.degrees(side.angle) == pytest.approx(90.0 + 7.14)
    assert side.depth == pytest.approx(0.0685 - 0.0645)
    # pooltool's own velocities after this stroke, turned by a right angle.
    v, w = scene.velocities[0], scene.angular_velocities[0]
    expected = [1.7071492226996685, 0.15631638459882075, 0.0]
    np.testing.assert_allclose(v, expected, rtol=1e-14)
    expected = [3.1386584768814214, -44.88490737168102, 44.99451174086551]
    np.testing.assert_allclose(w, expected, rtol=1e-13)


def test_a_simulated_shot_is_read_from_its_start(load):
    system = example()
    for ball in system["balls"].values():
        ball["history"]["states"] = [json.loads(json.dumps(ball["state"]))]
        ball["state"]["rvw"] = [[0.1, 0.1, 0.03], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    system["t"] = 3.0
    assert load(system).balls == load(example()).balls


WITHIN = 1e-4
"""Largest difference of rest positions [m]: pooltool moves balls apart by 1e-6 m at each impact,
which the path after the next impact multiplies by its length over a diameter."""

WRITTEN = ["cushion-stronge", "throw-alciatore", "pocket-bank", "coulomb-break-9", "cue-draw"]


@pytest.mark.parametrize("name", WRITTEN)
def test_a_written_scene_reads_back(load, name):
    scene = find_scene(name)
    found = load(json.loads(pooltool_json(scene)))
    for field in ("velocities", "angular_velocities", "radii", "masses"):
        np.testing.assert_array_equal(getattr(found, field), getattr(scene, field))
    for field in ("positions", "sliding_frictions", "rolling_frictions", "spinning_friction_rates"):
        expected = getattr(scene, field)
        np.testing.assert_allclose(getattr(found, field), expected, rtol=1e-15, atol=1e-15)
    if scene.physics.cushion == "stronge2000":
        expected = scene.physics.cushion_height
        assert found.physics.cushion_height == pytest.approx(expected, rel=1e-14)
    assert (found.table.length, found.table.width) == (scene.table.length, scene.table.width)
    assert (found.table.pockets is None) == (scene.table.pockets is None)


LACKING = [
    ("half-ball-cut", '`motion` must be "sliding"'),
    ("stop", '`motion` must be "sliding"|it needs a rectangular table'),
    ("flight-lands", "no air and no flight|it needs a rectangular table"),
]


@pytest.mark.parametrize(("name", "words"), LACKING)
def test_what_pooltool_lacks_is_refused(name, words):
    with pytest.raises(GhostballError, match=words):
        pooltool_json(find_scene(name))


def changed(system: dict, *path: str, to: object) -> dict:
    part = system
    for key in path[:-1]:
        part = part[key]
    part[path[-1]] = to
    return system


BAD = [
    ((("table", "cushion_segments"), {}), "`table.cushion_segments.linear`: field required"),
    ((("balls",), {}), "`balls`: dictionary should have at least 1 item"),
    ((("balls", "1", "params"), {"m": 0.17}), "`balls.1.params.R`: field required"),
    ((("balls", "1", "params", "R"), 2.8575), "`balls.1.params.R`: input should be less than"),
    ((("balls", "1", "params", "e_b"), 1.5), "must be .*got 1.5|equal"),
    ((("cue", "phi"), "north"), "`cue.phi`: input should be a valid number"),
    ((("table", "pockets"), {}), "neither a rectangle nor one of pooltool's pocket tables"),
    ((("table", "cushion_segments", "circular"), {}), "neither a rectangle"),
]


@pytest.mark.parametrize(("change", "words"), BAD, ids=range(len(BAD)))
def test_other_files_are_refused_in_one_line(load, change, words):
    path, value = change
    system = changed(example(), *path, to=value)
    if "e_b" in path:
        system["balls"]["cue"]["params"]["e_b"] = value
    with pytest.raises(GhostballError, match=words) as refused:
        load(system)
    assert "shot.json can't be read as a shot of pooltool" in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_moved_jaw_is_another_table(load):
    system = example()
    system["table"]["cushion_segments"]["circular"]["10t"]["center"][0] += 1e-6
    with pytest.raises(GhostballError, match="neither a rectangle nor one of"):
        load(system)


@pytest.mark.parametrize("text", ["", "{", "[]", "\x00", SAVED.read_text()[:3000]])
def test_files_that_are_cut_off_are_refused(tmp_path, text):
    (tmp_path / "shot.json").write_text(text)
    with pytest.raises(GhostballError, match=r"shot\.json can't be read as a shot"):
        load_pooltool(tmp_path / "shot.json")


@pytest.mark.slow
def test_pooltool_plays_the_same(tmp_path):
    """The real package with its default laws."""
    if not interpreter().is_file():
        pytest.skip("pooltool isn't installed: run `make peers`")
    scenes = {SAVED: load_pooltool(SAVED)}
    for name in ("cushion-stronge", "throw-alciatore"):
        path = tmp_path / f"{name}.json"
        path.write_text(pooltool_json(find_scene(name)))
        scenes[path] = load_pooltool(path)
    command = [interpreter(), "-E", "-s", "-c", PLAYED, *scenes]
    home = {"HOME": str(tmp_path), "XDG_CONFIG_HOME": str(tmp_path / "config")}
    lines = subprocess.check_output(command, text=True, env=os.environ | home).splitlines()
    for scene, line in zip(scenes.values(), lines, strict=True):
        x, y, z = np.array(json.loads(line)).T
        theirs = np.stack([y, scene.table.width - x, z], axis=1)
        ours = simulate(scene, record="events")
        pocketed = ours.outcomes().pocketed
        for hole in scene.table.holes:  # a pocketed ball is in the middle of its pocket
            inside = np.linalg.norm(theirs[:, :2] - hole.centre, axis=1) < 1e-9
            np.testing.assert_array_equal(inside, pocketed == hole.pocket)
        left = pocketed < 0
        np.testing.assert_allclose(theirs[left], ours.rest_positions[left], rtol=0.0, atol=WITHIN)
