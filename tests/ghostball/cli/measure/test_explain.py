"""`ghostball explain`: text, picture, and the exit status for bad input."""

import inspect
import json
from functools import partial
from types import SimpleNamespace

import pytest
from stored_records import record, written

from ghostball.cli.measure.explain import _worst_scene
from ghostball.cli.shared import single_shots
from ghostball.validation.results.records import Accuracy, Check


@pytest.fixture
def cli(cli):
    return partial(cli, "explain")


def test_where_two_shots_part(cli, tmp_path):
    picture = tmp_path / "parting.png"
    found = cli("break-7", "--engine", "pymunk", "--no-attribute", "--plot", picture)
    assert found.exit_code == 0, found.output
    for part in (
        "break-7 on pymunk, compared with the certified result",
        "The first wrong collision, at t = 0.62675331",
        '"1" hits "3" at t =',
        '"3" hits "5" at t =',
        "before the collision in the other run",
        "the smallest gap between",
        "reference",
        f"drawn in {picture}",
    ):
        assert part in found.stdout
    assert "Cause of the error" not in found.stdout
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_where_nothing_parts(cli):
    found = cli("half-ball-cut", "--engine", "paper-discrete")
    assert found.exit_code == 0, found.output
    for part in (
        "Every ball has the collisions of the reference.",
        'Largest time error: "cue" hits "object" 11.5 ms late',
        'Largest error at the end: "object", 92.9 mm',
        "Cause of the error",
        "with a time step of 5 ms",
        "with a time step of 1.25 ms",
        "the engine's time step: with a shorter one the error shrinks",
        "semi-implicit Euler",
    ):
        assert part in found.stdout


def test_json_is_one_object(cli):
    found = cli("stop", "--engine", "paper-continuous", "--format=json")
    assert found.exit_code == 0, found.output
    data = json.loads(found.stdout)
    assert data["schema"] == 6
    assert data["parting"] is None
    assert data["attribution"]["outcome"] == "step"
    assert [one["step"] for one in data["attribution"]["ladder"]] == [0.02, 0.005, 0.00125]
    assert found.stdout.count("\n") == 1


def test_a_run_that_does_not_end_fails(cli):
    found = cli("stop", "--engine", "pymunk:max_time=0.5", "--no-attribute")
    assert found.exit_code == 1
    assert "engine pymunk did not finish" in found.stderr
    assert "Largest error at the end" not in found.stdout


def test_a_wrong_factor_is_said_first(cli, tmp_path, monkeypatch):
    # The engine of `init` with 5/7 of the friction: one coefficient explains all frames and events.
    from ghostball.validation.examples import first_engine

    source = inspect.getsource(first_engine)
    wrong = source.replace("physics.gravity * physics.rolling_friction", "5 / 7 * 0.02 * 9.81")
    assert wrong != source
    (tmp_path / "five_sevenths.py").write_text(wrong, "utf-8")
    settings = '[tool.ghostball]\nengines = ["five_sevenths:simulate"]\n'
    (tmp_path / "pyproject.toml").write_text(settings, "utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    found = cli("stop")
    assert found.exit_code == 0, found.output
    first = " ".join(found.stdout.split("\n\n")[1].split())
    assert first.startswith(
        "From the start, five_sevenths:simulate behaves as if `rolling_friction` were 0.0143: 5/7 "
        "of 0.02."
    )
    assert "A rolling ball should slow by 0.196 m/s², but slows by 0.14." in first
    assert "█" in found.stdout.split("\n\n")[2]


BROKEN_LIMIT = Check("rest_error_max", 2e-3, "at_most", 1e-3, "m", passed=False, reason="x")


@pytest.mark.parametrize(
    ("found", "worst"),
    [
        ({"stop": "millimetres", "follow": "centimetres", "draw": "exact"}, "follow"),
        ({"stop": "centimetres", "follow": "another shot", "draw": "exact"}, "follow"),
        ({"stop": "another shot", "follow": "centimetres", "draw": "broken"}, "draw"),
    ],
)
def test_the_worst_scene_is_that_of_the_worst_accuracy_of_any_kind(tmp_path, found, worst):
    cases = [record("pymunk", name, accuracy=Accuracy(kind)) for name, kind in found.items()]
    written(tmp_path, *cases, record("ghostball", "break-7", accuracy=Accuracy("broken")))
    assert _worst_scene(tmp_path, "pymunk") == worst


def test_a_scene_that_breaks_a_limit_is_worse_than_one_that_breaks_none(tmp_path):
    held = record("pymunk", "stop", accuracy=Accuracy("millimetres", 2e-3), checks=(BROKEN_LIMIT,))
    written(tmp_path, held, record("pymunk", "draw", accuracy=Accuracy("another shot")))
    assert _worst_scene(tmp_path, "pymunk") == "stop"


def test_kernels_are_compiled_before_another_process_needs_them(cli, monkeypatch):
    # A message such as "engine pymunk printed: compiling ..." must not interrupt the answer.
    asked = []
    missing = [SimpleNamespace(is_made=False)]
    monkeypatch.setattr(single_shots, "needed_kernels", lambda *_: missing)
    monkeypatch.setattr(
        single_shots,
        "compile_kernels",
        lambda scenes, jobs, labels, compiling: asked.append((scenes[0].name, labels, compiling)),
    )
    found = cli("stop", "--engine", "pymunk", "--no-attribute")
    assert found.exit_code == 0, found.output
    ((scene, labels, compiling),) = asked
    assert (scene, labels) == ("stop", ["pymunk"])
    assert callable(compiling)
    assert "printed" not in found.output
