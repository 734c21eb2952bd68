"""Missing or wrong versions of Node.js and of packages, tested with a fake Node.js."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ghostball.cli import app
from ghostball.model import EngineFailedError
from ghostball.reference_adapters.javascript.engine import PlanckEngine
from ghostball.reference_adapters.javascript.packages import (
    FOLDER_VARIABLE,
    PACKAGES,
    installed,
    why_unavailable,
)
from ghostball.reference_adapters.workers import engine as workers
from ghostball.validation.parallel.sources import code_here, versions
from ghostball.validation.runs.engine_runs import run_engine
from ghostball.validation.scenes.library import find_scene

FAKE = """#!{python}
import json, sys, time
if sys.argv[1] == "--version":
    print({version!r})
    raise SystemExit
def say(value):
    print(json.dumps(value), flush=True)
say({hello})
for line in sys.stdin:
    asked = json.loads(line)
    balls = asked["scene"]["balls"]
    run = {{
        "scene": asked["scene"]["name"], "status": "rest", "rest_time": 1.0, "events": [],
        "rest_positions": [ball["position"] for ball in balls],
        "samples": {{"t": [0.0], "positions": [[ball["position"] for ball in balls]],
                     "velocities": [[[0, 0, 0]] * len(balls)],
                     "angular_velocities": [[[0, 0, 0]] * len(balls)]}},
    }}
    {answer}
"""

Node = Callable[..., None]


@pytest.fixture
def node(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Node:
    """Put only a fake `node` on the PATH, and install a fake package of planck."""
    package = tmp_path / "node_modules" / "planck"
    package.mkdir(parents=True)
    (package / "package.json").write_text('{"version": "9.8.7"}')
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path))
    path = tmp_path / "bin"
    path.mkdir()
    monkeypatch.setenv("PATH", str(path))

    def put(answer: str = "say(run)", version: str = "v20.1.0", hello: str = "") -> None:
        script = path / "node"
        script.write_text(
            FAKE.format(
                python=sys.executable,
                version=version,
                answer=answer,
                hello=hello or '{"version": "1"}',
            )
        )
        script.chmod(0o755)

    return put


def test_without_node_or_with_another_one_it_is_absent_and_says_why(
    node: Node, tmp_path: Path
) -> None:
    assert "isn't on the PATH" in str(why_unavailable("planck"))
    assert installed() == {}
    node()
    assert why_unavailable("planck") is None
    assert installed() == {"node": "v20.1.0", "planck": "9.8.7"}
    assert versions()["planck"] == code_here()["planck of the workers"] == "9.8.7"
    (tmp_path / "bin" / "node").unlink()
    assert "isn't on the PATH" in str(why_unavailable("planck"))


@pytest.mark.parametrize(
    ("version", "says"),
    [
        ("v14.21.3", "node must be 18 or newer, got v14.21.3 at "),
        ("Welcome!", "must print a version such as v20.1.0, got 'Welcome!'"),
    ],
)
def test_a_node_that_is_too_old_or_none_is_named(node: Node, version: str, says: str) -> None:
    node(version=version)
    assert says in str(PlanckEngine.unavailable())


def test_a_missing_package_is_named_with_its_installation(node: Node) -> None:
    node()
    for package in set(PACKAGES) - {"planck"}:
        assert f"`{package}` isn't in " in str(why_unavailable(package))
        assert "make peers-js" in str(why_unavailable(package))


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        ("print('bounce!', flush=True)", "must answer with one JSON object on a line, got 'bou"),
        ("say([1, 2])", r"must answer with one JSON object on a line, got '\[1, 2\]'"),
        ("time.sleep(60)", "ended without an answer: over 0 s"),
        ("sys.exit('out of chalk')", "ended without an answer: out of chalk"),
        ("say(run | {'scene': 'another'})", "for the requested scene, 'stop', got 'another'"),
        ("say(run | {'status': 'done'})", "the answer of `planck`: `status` must be 'rest'"),
        ("run['rest_positions'][0][0] = float('nan'); say(run)", "must be finite, got "),
        ("say({'error': 'TypeError: no'})", "TypeError: no"),
    ],
)
def test_a_wrong_answer_is_the_engines_failure_in_one_sentence(
    node: Node, monkeypatch: pytest.MonkeyPatch, answer: str, says: str
) -> None:
    monkeypatch.setattr(workers, "TIME_LIMIT", 0.4 if "sleep" in answer else 20.0)
    node(answer)
    with pytest.raises(EngineFailedError, match=says):
        run_engine(PlanckEngine(), find_scene("stop"))


def test_a_beginning_that_is_none_is_named(node: Node) -> None:
    node(hello="{'hello': 'world'}")
    with pytest.raises(EngineFailedError, match=r"must start with \{\"version\": ...\}, got "):
        run_engine(PlanckEngine(), find_scene("stop"))


def test_the_exit_status_tells_what_is_absent_from_what_fails(node: Node) -> None:
    def status() -> tuple[int, str]:

        done = CliRunner().invoke(app, ["run", "stop", "-e", "planck"])
        return done.exit_code, done.output

    code, said = status()
    assert code == 2
    assert "isn't on the PATH" in said
    node("print('bounce!', flush=True)")
    code, said = status()
    assert code == 1
    assert "must answer with one JSON object" in said
    node()
    assert status()[0] == 0
