"""JavaScript engines compared with closed forms, if Node.js and their packages are installed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from engine_facts import (
    FREE,
    cut_angles,
    energy_ratios,
    frozen_line,
    half_ball,
    head_on,
    needs,
    play,
    rack,
    shares,
    throw,
)
from typer.testing import CliRunner

from ghostball.cli import app
from ghostball.engine import simulate
from ghostball.model import Status, UnsupportedSceneError
from ghostball.reference_adapters.javascript.engine import PlanckEngine
from ghostball.reference_adapters.javascript.packages import DRIVER, folder
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.runs.engine_runs import run_engine
from ghostball.validation.scenes.library import find_scene

ENGINES = ("planck", "matter-js", "cannon-es")
NAMES = [pytest.param(name, marks=needs(name)) for name in ENGINES]
IN_DOUBLES = [pytest.param(name, marks=needs(name)) for name in ("planck", "cannon-es")]


@pytest.mark.parametrize("name", IN_DOUBLES)
def test_in_exact_steps_a_shot_is_right_to_nanometres(name: str) -> None:
    for scene in map(find_scene, ("half-ball-cut", "draw-shot", "corner-exact", "english-running")):
        engine = make_engine(f"{name}:contact_steps=exact")
        if scene.physics.cushion not in ("mirror", "restitution"):
            continue
        result, truth = run_engine(engine, scene), simulate(scene, record="events")
        assert np.abs(result.rest_positions - truth.rest_positions).max() < 2e-9, scene.name
        assert result.collision_counts == truth.collision_counts


@pytest.mark.parametrize("name", IN_DOUBLES)
def test_the_cloth_is_that_of_the_other_adapters(name: str) -> None:
    # Without contacts, the results differ only by rounding, at the end and before.
    for scene in map(find_scene, ("sliding-swerve", "roll-distance", "stop")):
        result, truth = run_engine(make_engine(name), scene), simulate(scene, record="trajectory")
        assert result.status is truth.status
        assert np.abs(result.rest_positions - truth.rest_positions).max() < 1e-9, scene.name
        assert [tuple(one)[1:] for one in result.events] == [tuple(one)[1:] for one in truth.events]
        times = np.linspace(0.0, truth.rest_time, 50)
        ours, theirs = result.sample(times), truth.sample(times)
        assert np.abs(ours.positions - theirs.positions).max() < 1e-5


@pytest.mark.parametrize("name", NAMES)
def test_a_cut_is_late_by_a_part_of_the_step_and_a_smaller_step_mends_it(name: str) -> None:
    spec = f"{name}:bullet=no" if name == "planck" else name
    sides = 0.8 if name == "matter-js" else 0.0  # half of the angle of one of 240 sides
    coarse, fine = (np.abs(cut_angles(spec, dt)).max() for dt in (1e-3, 1e-4))
    assert coarse < 0.8 + sides
    assert fine < 0.08 + sides


@needs("planck")
def test_bullets_of_planck_meet_where_they_touch() -> None:
    assert np.abs(cut_angles("planck", 1e-3)).max() < 1e-3


@pytest.mark.parametrize("name", NAMES)
def test_results_of_simultaneous_impacts(name: str) -> None:
    # Findings: racks conserve energy; balls that touch without overlap aren't in contact, so a line
    # of balls has successive collisions.
    assert shares(name, frozen_line()) == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)
    assert np.abs(energy_ratios(name, rack()) - 1.0).max() < 1e-6


@pytest.mark.parametrize("name", NAMES)
def test_what_is_not_driven_is_refused_and_a_limit_is_named(name: str) -> None:
    with pytest.raises(UnsupportedSceneError, match="without friction at contacts"):
        play(name, throw())
    one_by_one = half_ball(physics=FREE.model_copy(update={"impacts": "sequential"}))
    with pytest.raises(UnsupportedSceneError, match="all contacts of a time step together"):
        play(name, one_by_one)
    result = play(f"{name}:max_steps=10", find_scene("half-ball-cut"))
    assert result.status is Status.STEP_LIMIT
    assert "`max_steps` = 10 (at t = 0.01 s) was reached" in result.reason
    assert result.work["steps"] == 10
    assert result.settings["dt"] == 1e-3


@needs("planck")
def test_a_newcomers_planck_has_inelastic_slow_impacts() -> None:
    assert shares("planck:config=naive", head_on(0.9)) == pytest.approx([0.5, 0.5], abs=1e-3)
    assert shares("planck", head_on(0.009)) == pytest.approx([0.0, 1.0], abs=1e-6)


PACKAGE = """
console.log("chatter of the engine");
exports.Settings = {};
exports.World = class {
  constructor() { LOOP }
};
"""


@pytest.fixture
def loops(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Install a fake planck that prints, and then loops."""
    package = tmp_path / "node_modules" / "planck"
    package.mkdir(parents=True)
    (package / "package.json").write_text('{"version": "1.0.0", "main": "index.js"}')
    (package / "index.js").write_text(PACKAGE.replace("LOOP", "for (;;);"))
    monkeypatch.setenv("GHOSTBALL_PEERS_JS", str(tmp_path))
    return tmp_path


@needs("planck")
def test_what_an_engine_prints_is_no_answer_and_what_it_throws_is(loops: Path) -> None:
    text = PACKAGE.replace("LOOP", 'console.log("more"); throw new Error("no chalk")')
    (loops / "node_modules" / "planck" / "index.js").write_text(text)
    with pytest.raises(Exception, match="Error: no chalk"):
        run_engine(PlanckEngine(), find_scene("stop"))


@needs("planck")
@pytest.mark.slow
def test_an_engine_that_loops_ends_with_its_caller(loops: Path) -> None:
    ask = (
        "import os, threading; from ghostball.reference_adapters.javascript import engine;"
        "from ghostball.validation.scenes.library import find_scene;"
        "asked = threading.Thread(target=engine.PlanckEngine().simulate,"
        " args=(find_scene('stop'),), daemon=True); asked.start(); asked.join(3.0);"
        "command = (engine.shutil.which('node'), str(engine.DRIVER / 'serve.mjs'));"
        f"worker = engine.worker_of(*command, {str(folder())!r}, 'planck', 'tuned');"
        "print(worker._process.pid, flush=True); os._exit(0)"
    )
    done = subprocess.run([sys.executable, "-c", ask], capture_output=True, text=True, check=True)
    pid = int(done.stdout)
    for _ in range(100):
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return
        time.sleep(0.1)
    os.kill(pid, signal.SIGKILL)
    pytest.fail("node went on")


@needs("planck")
def test_the_driver_plays_files_for_grade(tmp_path: Path) -> None:
    scene = tmp_path / "stop.json"
    scene.write_text(find_scene("stop").model_dump_json(by_alias=True))
    command = ["node", str(DRIVER / "serve.mjs"), str(folder()), "planck", "tuned", str(scene)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    runs = tmp_path / "runs.jsonl"
    runs.write_text(done.stdout)
    graded = CliRunner().invoke(app, ["grade", str(runs)])
    assert graded.exit_code == 0
    assert "planck-alone" in graded.output
