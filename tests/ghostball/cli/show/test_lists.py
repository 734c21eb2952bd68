"""Lists of `ghostball scenes` and `engines`; recipes are as accurate as they claim."""

import importlib.metadata
import importlib.util
import runpy
import subprocess
import sys

import numpy as np
import pytest

from ghostball import find_scene, simulate
from ghostball.cli.show.engines import _EngineDescription, _recipes, _version
from ghostball.reference_adapters import engine_class
from ghostball.validation.scenes.library import select


@pytest.mark.parametrize("tag", ["full", "board"])
def test_scenes_lists_every_shipped_scene_with_its_tags(cli, tag):
    shown = cli("scenes", tag).stdout
    assert all(f" {scene.name} " in shown for scene in select([tag]))
    assert tag == "full" or "reported" in shown


def test_lists_are_chosen_from_and_for_programs_too(cli):
    for options, key in (((), "scenes"), (("--metrics",), "metrics")):
        assert cli("scenes", *options, "--format", "json").stdout.startswith(f'{{"{key}": ')
    assert cli("scenes", "stop").stdout.startswith("schema = 1\n")
    smoke = cli("scenes", "smoke").stdout
    assert "half-ball-cut" in smoke
    assert "around-the-table" not in smoke
    assert "rest_error_max" in cli("scenes", "--metrics").stdout


def test_engines_are_a_table_that_fits_a_terminal(cli, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    lines = cli("engines").stdout.splitlines()
    assert max(map(len, lines)) <= 80
    rows = {line.split()[0]: line.split() for line in lines if line.strip()}
    version = importlib.metadata.version("ghostball")
    assert rows["ghostball"][1:] == [version, "yes", "nothing"]
    assert rows["paper-discrete"][1:4] == [version, "yes", "sliding"]  # what most scenes need


def test_an_engine_that_is_not_here_takes_a_word_of_the_table_and_not_its_reason(cli, monkeypatch):
    # With reasons, the table would be too high for a screen, because paths are long.
    reason = "needs /a/path " + 20 * "that is long "
    monkeypatch.setattr(
        "ghostball.cli.show.engines._described", lambda _: _EngineDescription(reason)
    )
    shown = cli("engines").stdout
    assert "Not installed: ghostball, billiards, box2d, " in shown
    assert "that is long" not in shown
    assert len(shown.splitlines()) < 40


def test_the_name_of_no_engine_is_bad_input(cli):
    # A script with a typo in a name must stop.
    found = cli("engines", "pymunkk")
    assert found.exit_code == 2
    assert "Did you mean `pymunk`?" in " ".join(found.stderr.split())


def test_engines_lists_settings_and_capabilities(cli):
    shown = cli("engines", "ghostball", "pymunk").stdout
    for part in (
        "ghostball  available",
        "max_events=",
        "contact_steps=fixed (exact)",
        "dt unset",
        "unsupported",
        "pure rolling",
    ):
        assert part in shown
    assert "paper-discrete" not in shown


def test_the_version_of_an_engine_is_that_of_the_package_that_brings_it(monkeypatch):
    # The version must not come from an unrelated Python distribution with the engine's name, and
    # must be found if the distribution has another name.
    there = {"planck": "1.4.2", "pymunk": "9.9.9", "mujoco-core": "4.0", "ghostball": "0.1"}
    monkeypatch.setattr("ghostball.cli.show.engines.versions", lambda: there)
    monkeypatch.setattr("ghostball.cli.show.engines.version_of", {"brought": "3.0"}.get)
    names = ("planck", "cannon-es", "pymunk", "mujoco", "paper-discrete")
    found = [_version(engine_class(name)) for name in names]
    assert found == ["1.4.2", "", "9.9.9", "4.0", "0.1"]
    assert _version(type("Own", (), {"name": "own", "__module__": "brought.engine"})) == "3.0"


# --- recipes

TRUE = simulate(find_scene("half-ball-cut")).rest_positions[:, :2]


def off(places) -> float:
    return float(np.max(np.linalg.norm(np.array(places) - TRUE, axis=1)))


def test_a_recipe_is_code_of_that_engine_alone(cli):
    found = cli("engines", "pymunk", "--recipe").stdout
    compile(found, "recipe", "exec")
    assert "import pymunk" in found
    assert "ghostball" not in found


def test_pymunk_is_some_millimetres_off_in_its_own_steps_and_right_where_contacts_are_met():
    pytest.importorskip("pymunk")
    (path,) = _recipes("pymunk")
    play = runpy.run_path(str(path))["play"]
    own, exact = (off([tuple(ball.position) for ball in play(exact)]) for exact in (False, True))
    assert 1e-3 < own < 5e-3
    assert exact < 1e-6


@pytest.mark.parametrize(
    ("name", "package"),
    [
        ("box2d", "Box2D"),
        ("box2d3", "pyb2d3"),
        ("dart", "dartpy"),
        ("mujoco", "mujoco"),
        ("newton", "newton"),
        ("physx", "sapien"),
        ("pybullet", "pybullet"),
        ("rapier", "rapier3d"),
    ],
)
def test_a_recipe_is_some_millimetres_off_in_its_own_steps(name, package):
    """Run a recipe in its own process, as users do: some engines allow only one connection."""
    if importlib.util.find_spec(package) is None:
        pytest.skip(f"{package} isn't installed")
    (path,) = _recipes(name)
    printed = subprocess.check_output([sys.executable, str(path)], text=True, timeout=60)
    lines = [line for line in printed.splitlines() if line.startswith("  ")]
    places = [tuple(map(float, line.split(","))) for line in lines]
    assert 5e-4 < off(places) < 5e-3
