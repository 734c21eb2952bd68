"""Lists of what there is: scenes, engines, metrics, recipes."""

import importlib.metadata

from ghostball.cli.show.engines import _Described, _version
from ghostball.reference_adapters import engine_class
from ghostball.validation.scenes.library import select


def test_scenes_lists_every_shipped_scene_with_its_tags(cli):
    for tag in ("full", "board"):
        result = cli("scenes", tag)
        assert result.exit_code == 0
        for scene in select([tag]):
            assert f" {scene.name} " in result.stdout
    assert "reported" in result.stdout


def test_engines_are_a_table_with_a_line_of_each(cli):
    rows = {
        line.split()[0]: line.split() for line in cli("engines").stdout.splitlines() if line.strip()
    }
    version = importlib.metadata.version("ghostball")
    assert rows["ghostball"][1:] == [version, "yes", "nothing"]
    assert rows["paper-discrete"][1:4] == [version, "yes", "sliding"]  # what most scenes need


def test_engines_lists_settings_and_capabilities(cli):
    result = cli("engines", "ghostball", "pymunk")
    assert result.exit_code == 0
    for part in (
        "ghostball  available",
        "max_events=",
        "contact_steps=fixed (exact)",
        "dt unset",
        "not represented",
        "balls that roll and never slide",
    ):
        assert part in result.stdout


def test_lists_are_for_programs_too(cli):
    for options, key in (((), "scenes"), (("--metrics",), "metrics")):
        assert cli("scenes", *options, "--format", "json").stdout.startswith(f'{{"{key}": ')
    assert cli("scenes", "stop").stdout.startswith("schema = 1\n")
    assert "half-ball-cut" in cli("scenes", "smoke").stdout
    assert "around-the-table" not in cli("scenes", "smoke").stdout
    assert "rest_error_max" in cli("scenes", "--metrics").stdout
    assert "pymunk  available" in cli("engines", "pymunk").stdout
    assert "paper-discrete" not in cli("engines", "pymunk").stdout


def test_the_table_of_engines_fits_a_terminal(cli, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    lines = cli("engines").stdout.splitlines()
    assert max(map(len, lines)) <= 80
    assert "".join(lines).count(" pymunk ") == 1


def test_an_engine_that_is_not_here_takes_a_word_of_the_table_and_not_its_reason(cli, monkeypatch):
    # Breaks where the table says why: a path of node_modules took it over the height of a screen.
    monkeypatch.setenv("COLUMNS", "80")
    reason = "needs /a/path " + 20 * "that is long "
    monkeypatch.setattr("ghostball.cli.show.engines._described", lambda _: _Described(reason))
    shown = cli("engines").stdout
    assert "Not here: ghostball, billiards, box2d, " in shown
    assert "that is long" not in shown
    assert len(shown.splitlines()) < 40


def test_the_version_of_an_engine_is_that_of_the_package_that_brings_it(monkeypatch):
    # Breaks where a Python distribution of that name is asked, which is other people's, or that of
    # an engine that is installed under another name isn't found.
    there = {"planck": "1.4.2", "pymunk": "9.9.9", "mujoco-core": "4.0", "ghostball": "0.1"}
    monkeypatch.setattr("ghostball.cli.show.engines.versions", lambda: there)
    monkeypatch.setattr("ghostball.cli.show.engines.version_of", {"brought": "3.0"}.get)
    names = ("planck", "cannon-es", "pymunk", "mujoco", "paper-discrete")
    found = [_version(engine_class(name)) for name in names]
    assert found == ["1.4.2", "", "9.9.9", "4.0", "0.1"]
    assert _version(type("Own", (), {"name": "own", "__module__": "brought.engine"})) == "3.0"


def test_a_recipe_is_code_of_that_engine_alone(cli):
    found = cli("engines", "pymunk", "--recipe")
    assert found.exit_code == 0, found.output
    compile(found.stdout, "recipe", "exec")
    assert "import pymunk" in found.stdout
    assert "ghostball" not in found.stdout
