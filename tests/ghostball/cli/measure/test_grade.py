"""Engines in any language: scenes go out as JSON, runs come back and are judged as any engine's."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from ghostball.cli import app
from ghostball.engine import simulate
from ghostball.model import Scene
from ghostball.reference_adapters.answer import Run
from ghostball.reference_adapters.base import EngineError
from ghostball.reference_adapters.elsewhere import load_runs
from ghostball.validation.scenes.library import find_scene, select

EXAMPLES = Path(__file__).parents[4] / "validation" / "examples"


def made_elsewhere(name: str) -> dict:
    """Return our own run of a scene as another program would write it."""
    result = simulate(find_scene(name), record="trajectory")
    assert result.events is not None
    near = [t + side for t in result.events["t"] for side in (-1e-9, 1e-9)]
    times = np.unique([0.0, *near, *np.arange(0.0, result.rest_time, 0.002), result.rest_time])
    times = times[times >= 0.0]
    positions, velocities, spins = result.sample(times)
    return result.to_dict() | {
        "engine": "elsewhere",
        "samples": {
            "t": times.tolist(),
            "positions": positions.tolist(),
            "velocities": velocities.tolist(),
            "angular_velocities": spins.tolist(),
        },
    }


def displace(run: dict, by: float) -> None:
    """Let the first ball end elsewhere, in the last sample too [m]."""
    run["rest_positions"][0][0] += by
    run["samples"]["positions"][-1][0][0] += by


def graded(tmp_path: Path, *runs: dict) -> tuple[int, str]:
    path = tmp_path / "runs.jsonl"
    path.write_text("\n".join(json.dumps(run) for run in runs))
    done = CliRunner().invoke(app, ["grade", str(path)])
    return done.exit_code, done.output


def test_scenes_come_back_the_same(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["scenes", "--export", str(tmp_path)])
    assert done.exit_code == 0
    for shipped in select():
        scene = Scene.model_validate(json.loads((tmp_path / f"{shipped.name}.json").read_text()))
        assert scene.physics == shipped.physics
        np.testing.assert_array_equal(scene.angular_velocities, shipped.angular_velocities)


def test_a_right_run_passes_and_a_wrong_one_fails(tmp_path: Path) -> None:
    right = [made_elsewhere(name) for name in ("half-ball-cut", "wall-bounce", "draw-shot")]
    status, shown = graded(tmp_path, *right)
    assert status == 0, shown
    # Planted errors: a ball that rests elsewhere, a collision that nobody saw.
    off, blind = made_elsewhere("half-ball-cut"), made_elsewhere("half-ball-cut")
    displace(off, 0.002)
    status, shown = graded(tmp_path, off)
    assert status == 1
    assert "accuracy must be <= nanometres, got millimetres: 0.002 m off" in shown
    blind["events"] = blind["events"][1:]
    del blind["collision_counts"]
    status, shown = graded(tmp_path, blind)
    assert status == 1
    assert "ball_ball_count_error must be == 0, got 1" in shown


def test_who_claims_rounding_is_held_to_it_as_where_its_motion_is_known(tmp_path: Path) -> None:
    # Frames were graded as those of an engine that steps: 500 nm off passed, `resolution` 0 or not.
    for name in ("half-ball-cut", "wall-bounce"):
        run = made_elsewhere(name) | {"resolution": 0.0}
        assert graded(tmp_path, run)[0] == 0
        displace(run, 5e-7)
        status, shown = graded(tmp_path, run)
        assert status == 1
        assert "quality_factor must be <= 32" in shown


def test_a_run_that_contradicts_itself_is_judged_by_none_of_its_numbers(tmp_path: Path) -> None:
    run = made_elsewhere("half-ball-cut")
    run["rest_positions"][0][0] += 1e-4
    status, shown = graded(tmp_path, run)
    assert status == 1
    assert "`rest_positions[0]` must be where the motion has ball" in shown


def test_a_run_has_no_name_of_an_installed_engine(tmp_path: Path) -> None:
    # Limits go by the name: pymunk's default settings are excused from those that hold for all.
    run = made_elsewhere("stop") | {"engine": "pymunk", "settings": {"config": "naive"}}
    status, shown = graded(tmp_path, run)
    assert status == 2
    assert "must not be 'pymunk'" in shown


def test_the_others_are_judged_where_a_run_is_refused(tmp_path: Path) -> None:
    right, off = made_elsewhere("stop"), made_elsewhere("stop") | {"engine": "off"}
    displace(off, 0.1)
    refused = [right | {"engine": "pymunk"}, right | {"scene": "no-such"}]
    status, shown = graded(tmp_path, refused[0], right, off, refused[1])
    assert status == 2
    assert "stop on off" in shown
    assert "must not be 'pymunk'" in shown
    assert "'no-such'" in shown


@pytest.mark.parametrize("name", ["../../etc/passwd", "/etc/passwd", "own.toml", "./stop", "own"])
def test_no_run_opens_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    # Whoever made the run chose which file of whoever grades it was opened.
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "400")
    find_scene("stop").save(tmp_path / "own.toml")
    (tmp_path / "run.json").write_text(json.dumps(made_elsewhere("stop") | {"scene": name}))
    done = CliRunner().invoke(app, ["grade", "run.json"])
    assert done.exit_code == 2
    rule = "must be the name of a shipped scene, or the scene itself as an object, got "
    assert f"`scene` of a run {rule}{name!r}" in done.stderr


def test_who_claims_less_is_asked_for_less(tmp_path: Path) -> None:
    run = made_elsewhere("half-ball-cut")
    displace(run, 0.002)
    nearly = {"balls that roll and never slide": "in steps"}
    status, shown = graded(tmp_path, run | {"approximate": nearly})
    assert status == 4, shown  # it makes no energy, and nothing limits how it ends
    assert graded(tmp_path, run | {"resolution": 5e-4})[0] == 0
    assert graded(tmp_path, run | {"resolution": 10.0})[0] == 4  # says as much as nothing
    assert graded(tmp_path, run | {"resolution": 1e-6})[0] == 1
    with pytest.raises(EngineError, match=r"`approximate.rolling.*` must be 'balls that"):
        Run.parse(run | {"approximate": {"rolling": "so"}}, "a file, run 1")


def test_a_whole_scene_may_stand_in_a_run(tmp_path: Path) -> None:
    run = made_elsewhere("half-ball-cut")
    run["scene"] = find_scene("half-ball-cut").model_dump(mode="json", by_alias=True)
    assert graded(tmp_path, run)[0] == 0


def played(tmp_path: Path, *command: str) -> int:
    """Have a program play exported scenes, and return the status with which they are graded."""
    CliRunner().invoke(app, ["scenes", "--export", str(tmp_path)])
    scenes = [str(tmp_path / f"{name}.json") for name in ("half-ball-cut", "wall-bounce")]
    done = subprocess.run([*command, *scenes], check=True, capture_output=True, text=True)
    (tmp_path / "out.jsonl").write_text(done.stdout)
    return CliRunner().invoke(app, ["grade", str(tmp_path / "out.jsonl")]).exit_code


@pytest.mark.slow
@pytest.mark.checkout
def test_the_example_in_cpp_plays(tmp_path: Path) -> None:
    compile_it = ["c++", "-std=c++17", "-O2", str(EXAMPLES / "stepper.cpp"), "-o"]
    if shutil.which("c++") is None:
        pytest.skip("there is no C++ compiler")
    header = subprocess.run(
        ["c++", "-E", "-x", "c++", "-"],
        input="#include <nlohmann/json.hpp>",
        text=True,
        check=False,
        capture_output=True,
    )
    if header.returncode:
        pytest.skip("nlohmann-json3-dev isn't installed")
    program = str(tmp_path / "stepper")
    subprocess.run([*compile_it, program], check=True)
    assert played(tmp_path, program) == 0


@pytest.mark.slow
@pytest.mark.checkout
def test_the_example_in_javascript_plays(tmp_path: Path) -> None:
    if shutil.which("npm") is None:
        pytest.skip("npm isn't installed")
    shutil.copy(EXAMPLES / "planck.mjs", tmp_path)
    install = [
        "npm",
        "install",
        "--silent",
        "--fetch-retries",
        "0",
        "--prefix",
        str(tmp_path),
        "planck@1.4",
    ]
    if subprocess.run(install, check=False, capture_output=True).returncode:
        pytest.skip("npm can't install planck here")
    assert played(tmp_path, "node", str(tmp_path / "planck.mjs")) == 0


@pytest.mark.slow
@pytest.mark.checkout
def test_the_example_in_gdscript_plays(tmp_path: Path) -> None:
    godot = shutil.which("godot3-server") or shutil.which("godot4") or shutil.which("godot")
    if godot is None:
        pytest.skip("there is no Godot")
    scene = EXAMPLES.parent / "scenes/board/p2-156.toml"
    CliRunner().invoke(app, ["scenes", str(scene), "--export", str(tmp_path)])
    script = "godot3.gd" if godot.endswith("godot3-server") else "godot4.gd"
    runs = tmp_path / "runs.jsonl"
    asked = {"GHOSTBALL_SCENES": str(tmp_path / "p2-156.json"), "GHOSTBALL_RUNS": str(runs)}
    command = [godot, "--headless", "--script", str(EXAMPLES / script), "--fixed-fps", "60"]
    command = [one for one in command if one != "--headless" or script == "godot4.gd"]
    subprocess.run(command, check=True, capture_output=True, env=os.environ | asked, timeout=60)
    (run,) = load_runs(runs)
    assert [event.kind for event in run.events] == ["ball-cushion"] * 4
    graded = CliRunner().invoke(app, ["grade", str(runs)])
    assert graded.exit_code == 0, graded.output
