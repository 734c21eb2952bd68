"""Engines in any language: exported scenes, and grades of the written results."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from commands import refused

from ghostball.engine import simulate
from ghostball.model import Scene
from ghostball.reference_adapters.answer import EngineAnswer
from ghostball.reference_adapters.base import EngineError
from ghostball.reference_adapters.run_files import load_runs
from ghostball.validation.scenes.library import find_scene, select

EXAMPLES = Path(__file__).parents[4] / "validation" / "examples"


def made_elsewhere(name: str, off: float = 0.0, blind: bool = False, **said: object) -> dict:
    """Return Ghostball's run of a scene in the format of result files, with some fields changed.

    `off`: displacement of the first ball's rest position, also in the last sample [m]. `blind`:
    whether the first event is missing.
    """
    result = simulate(find_scene(name), record="trajectory")
    near = [t + side for t in result.events["t"] for side in (-1e-9, 1e-9)]
    times = np.unique([0.0, *near, *np.arange(0.0, result.rest_time, 0.002), result.rest_time])
    times = times[times >= 0.0]
    motion = [states.tolist() for states in result.sample(times)]
    names = ("t", "positions", "velocities", "angular_velocities")
    samples = dict(zip(names, (times.tolist(), *motion), strict=True))
    run = result.to_dict() | {"engine": "elsewhere", "samples": samples}
    run["rest_positions"][0][0] += off
    samples["positions"][-1][0][0] += off
    if blind:
        del run["events"][0], run["collision_counts"]
    return run | said


@pytest.fixture
def graded(cli, here):
    """Grade runs, and return the exit status and the output."""

    def grade(*runs: dict) -> tuple[int, str]:
        (here / "runs.jsonl").write_text("\n".join(json.dumps(run) for run in runs))
        done = cli("grade", "runs.jsonl")
        return done.exit_code, done.output

    return grade


def test_scenes_come_back_the_same(cli, here):
    assert cli("scenes", "--export", ".").exit_code == 0
    for shipped in select():
        scene = Scene.model_validate(json.loads((here / f"{shipped.name}.json").read_text()))
        assert scene.physics == shipped.physics
        np.testing.assert_array_equal(scene.angular_velocities, shipped.angular_velocities)


CUT = "half-ball-cut"
NEARLY = {"pure rolling": "in steps"}
WHOLE = find_scene(CUT).model_dump(mode="json", by_alias=True)
JUDGED = [
    ({}, 0, ""),
    ({"scene": WHOLE}, 0, ""),
    # Planted errors: a wrong rest position, an invented collision.
    ({"off": 2e-3}, 1, "accuracy must be at most nanometres, got millimetres: position error 2 mm"),
    ({"blind": True}, 1, "ball_ball_count_error must be exactly 0, got 1"),
    # Runs were once graded like those of a time-stepping engine: errors of 500 nm always passed.
    ({"resolution": 0.0}, 0, ""),
    ({"resolution": 0.0, "off": 5e-7}, 1, "quality_factor must be at most 32"),
    # A run that claims less has fewer limits: the energy must not rise, final positions are free.
    ({"off": 2e-3, "approximate": NEARLY}, 4, ""),
    ({"off": 2e-3, "resolution": 5e-4}, 0, ""),
    ({"off": 2e-3, "resolution": 10.0}, 4, ""),  # a useless resolution
    ({"off": 2e-3, "resolution": 1e-6}, 1, ""),
    # Limits depend on the name: pymunk with default settings is excused from common limits.
    ({"engine": "pymunk", "settings": {"config": "naive"}}, 2, "must not be 'pymunk'"),
]
"""Changed fields of a run of a cut, the exit status, and a part of the message."""


@pytest.mark.parametrize(("said", "status", "words"), JUDGED, ids=range(len(JUDGED)))
def test_a_run_is_judged_by_its_numbers_and_its_claims(graded, said, status, words):
    found, shown = graded(made_elsewhere(CUT, **said))
    assert found == status, shown
    assert words in shown


def test_several_right_runs_pass(graded):
    assert graded(*map(made_elsewhere, (CUT, "wall-bounce", "draw-shot")))[0] == 0


def test_a_run_that_contradicts_itself_is_judged_by_none_of_its_numbers(graded):
    run = made_elsewhere(CUT)
    run["rest_positions"][0][0] += 1e-4
    status, shown = graded(run)
    assert status == 1
    assert "`rest_positions[0]` must be the position of ball" in shown


def test_valid_runs_are_judged_if_another_run_is_rejected(graded):
    right, off = made_elsewhere("stop"), made_elsewhere("stop", off=0.1, engine="off")
    status, shown = graded(right | {"engine": "pymunk"}, right, off, right | {"scene": "no-such"})
    assert status == 2
    assert all(part in shown for part in ("stop on off", "must not be 'pymunk'", "'no-such'"))


@pytest.mark.parametrize("name", ["../../etc/passwd", "/etc/passwd", "own.toml", "./stop", "own"])
def test_no_run_opens_a_file(cli, here, name):
    # Otherwise the author of a run could choose a file that Ghostball opens.
    find_scene("stop").save(here / "own.toml")
    (here / "run.json").write_text(json.dumps(made_elsewhere("stop", scene=name)))
    rule = "must be the name of a shipped scene, or the whole scene as an object, got "
    assert refused(cli("grade", "run.json"), f"`scene` of a run {rule}{name!r}")


def test_an_approximation_is_of_a_feature_that_there_is():
    with pytest.raises(EngineError, match="`approximate` must have as keys the names of features"):
        EngineAnswer.parse(made_elsewhere("stop", approximate={"rolling": "so"}), "a file, run 1")


# --- the examples in other languages


def exported(cli, *names: str) -> list[str]:
    """Export scenes to the working directory; return their files."""
    cli("scenes", "--export", ".")
    return [f"{name}.json" for name in names or (CUT, "wall-bounce")]


def plays(cli, *command: str) -> bool:
    """Check that a program simulates exported scenes, and that its runs pass."""
    done = subprocess.check_output([*command, *exported(cli)], text=True)
    Path("out.jsonl").write_text(done)
    return cli("grade", "out.jsonl").exit_code == 0


@pytest.mark.slow
@pytest.mark.checkout
def test_the_example_in_cpp_plays(cli, here):
    if shutil.which("c++") is None:
        pytest.skip("there is no C++ compiler")
    (here / "has.cpp").write_text("#include <nlohmann/json.hpp>")
    if subprocess.run(["c++", "-E", "has.cpp"], check=False, capture_output=True).returncode:
        pytest.skip("nlohmann-json3-dev isn't installed")
    source = str(EXAMPLES / "stepper.cpp")
    subprocess.run(["c++", "-std=c++17", "-O2", source, "-o", "stepper"], check=True)
    assert plays(cli, "./stepper")


@pytest.mark.slow
@pytest.mark.checkout
def test_the_example_in_javascript_plays(cli, here):
    if shutil.which("npm") is None:
        pytest.skip("npm isn't installed")
    shutil.copy(EXAMPLES / "planck.mjs", here)
    install = ["npm", "install", "--silent", "--fetch-retries", "0", "--prefix", ".", "planck@1.4"]
    if subprocess.run(install, check=False, capture_output=True).returncode:
        pytest.skip("npm can't install planck here")
    assert plays(cli, "node", "planck.mjs")


@pytest.mark.slow
@pytest.mark.checkout
def test_the_example_in_gdscript_plays(cli, here):
    godot = shutil.which("godot3-server") or shutil.which("godot4") or shutil.which("godot")
    if godot is None:
        pytest.skip("there is no Godot")
    cli("scenes", EXAMPLES.parent / "scenes/board/p2-156.toml", "--export", ".")
    old = godot.endswith("godot3-server")
    script = str(EXAMPLES / ("godot3.gd" if old else "godot4.gd"))
    asked = {"GHOSTBALL_SCENES": str(here / "p2-156.json"), "GHOSTBALL_RUNS": str(here / "runs")}
    command = [godot, *([] if old else ["--headless"]), "--script", script, "--fixed-fps", "60"]
    subprocess.run(command, check=True, capture_output=True, env=os.environ | asked, timeout=60)
    (run,) = load_runs(here / "runs")
    assert [event.kind for event in run.events] == ["ball-cushion"] * 4
    assert cli("grade", "runs").exit_code == 0
