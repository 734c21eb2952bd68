"""A process that simulates scenes: requests, answers, and failures."""

from __future__ import annotations

import json
import os
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import version
from pathlib import Path

import pytest
from echo_worker import worker
from named_pipes import read_to_end

from ghostball.model import Ball, Physics, Scene
from ghostball.reference_adapters.workers.process import (
    PYTHON,
    Worker,
    WorkerFailedError,
    installed,
)
from ghostball.validation.parallel.sources import code_here
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.suite.unchanged import code_hash


def test_a_worker_in_any_language_is_asked_and_answers(tmp_path: Path) -> None:
    one = worker(tmp_path, {"status": "rest"})
    assert one.play(find_scene("stop"), "rest", 20.0) == {"status": "rest"}
    one.close()


def test_a_workers_error_is_its_own(tmp_path: Path) -> None:
    one = worker(tmp_path, {"error": "no chalk"})
    with pytest.raises(WorkerFailedError, match="no chalk"):
        one.play(find_scene("stop"), "rest", 20.0)
    one.close()


@pytest.mark.skipif(os.name == "nt", reason="process groups are POSIX")
def test_a_program_that_a_worker_started_ends_with_it(tmp_path: Path) -> None:
    # A child once held the worker's output open, and reading waited forever for its end.
    script, pipe = tmp_path / "starts.py", tmp_path / "pipe"
    os.mkfifo(pipe)
    script.write_text(
        "import subprocess\n"
        'print(\'{"version": "1"}\', flush=True)\n'
        "input()\n"
        f"pipe = open({str(pipe)!r}, 'wb', buffering=0)\n"
        "pipe.write(b'there')\n"
        'subprocess.run(["sleep", "60"], stderr=pipe)\n'
    )
    one = Worker([sys.executable, str(script)])
    with ThreadPoolExecutor(1) as thread:
        opened = thread.submit(pipe.open, "rb")
        begun = time.monotonic()
        with pytest.raises(WorkerFailedError, match="over 1 s"):
            one.play(find_scene("stop"), "rest", 1.0)
        assert time.monotonic() - begun < 30.0
    with opened.result() as file:
        assert read_to_end(file) == b"there"  # the pipe ends when no process holds its other end


def test_all_that_the_workers_have_is_in_the_hash_of_the_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(PYTHON, sys.executable)
    assert installed()["pydantic"] == version("pydantic")
    assert code_here()["pydantic of the workers"] == version("pydantic")
    with_them = code_hash()
    monkeypatch.setenv(PYTHON, str(tmp_path / "nowhere"))
    assert installed() == {}
    assert code_hash() != with_them


def sent_with(tmp_path: Path, scene: Scene) -> dict:
    """Return the request for a worker to simulate a scene."""
    script = tmp_path / "keep.py"
    kept = tmp_path / "kept"
    script.write_text(
        'import sys\nprint(\'{"version": "1"}\', flush=True)\n'
        f"open({str(kept)!r}, 'w').write(sys.stdin.readline())\nprint('{{}}', flush=True)\n"
    )
    one = Worker([sys.executable, str(script)])
    one.play(scene, "events", 20.0)
    one.close()
    sent: dict = json.loads(kept.read_text())
    return sent


def test_what_is_sent_is_a_scene(tmp_path: Path) -> None:
    scene = find_scene("draw-shot")
    sent = sent_with(tmp_path, scene)
    assert sent["record"] == "events"
    assert type(scene).model_validate(sent["scene"]) == scene


def test_a_struck_ball_is_sent_with_its_velocities(tmp_path: Path) -> None:
    strike = {"speed": 2.0, "direction": 0.3, "offset_left": 0.2}
    scene = Scene(
        name="struck",
        physics=Physics(motion="sliding"),
        balls=[Ball(id="cue", position=(0.0, 0.0), strike=strike)],
    )
    (ball,) = sent_with(tmp_path, scene)["scene"]["balls"]
    assert "strike" not in ball
    assert ball["velocity"] == scene.velocities[0].tolist()
    assert ball["angular_velocity"] == scene.angular_velocities[0].tolist()
