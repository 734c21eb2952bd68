"""The script that serves a Python engine: answers and failures."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from ghostball.reference_adapters.workers.process import SCRIPTS, Worker, WorkerFailedError
from ghostball.validation.scenes.library import find_scene

SERVED = """
import os, sys
def version():
    return "9.1"
def simulate(scene, record):
    print("chatter of the engine")
    name = scene["name"]
    if name == "bad":
        raise ValueError("bad scene")
    if name == "crash":
        sys.stderr.write("out of chalk\\n")
        sys.stderr.flush()
        os._exit(3)
    if name == "hang":
        import time
        time.sleep(60)
    return {"rest_time": 0.25}
"""


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Callable[..., dict]]:
    """Simulate a scene with a given name on a Python engine served by `serve.py`."""
    shutil.copy(SCRIPTS / "serve.py", tmp_path)
    (tmp_path / "mine.py").write_text(SERVED)
    one = Worker([sys.executable, str(tmp_path / "serve.py"), "mine"])

    def play(name: str = "stop", longest: float = 20.0) -> dict:
        scene = find_scene("stop").model_copy(update={"name": name})
        return one.play(scene, "rest", longest)

    yield play
    one.close()


def test_a_crash_is_reported_with_its_last_words_and_the_next_scene_starts_anew(served) -> None:
    assert served() == {"rest_time": 0.25}
    with pytest.raises(WorkerFailedError, match="ended without an answer: out of chalk"):
        served("crash")
    with pytest.raises(WorkerFailedError, match="ValueError: bad scene"):
        served("bad")
    assert served() == {"rest_time": 0.25}


def test_a_worker_that_hangs_is_given_up(served) -> None:
    served()
    with pytest.raises(WorkerFailedError, match="without an answer: over 0 s"):
        served("hang", longest=0.2)
