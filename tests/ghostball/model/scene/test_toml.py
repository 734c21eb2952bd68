"""Scene files: read back to the bit, written whole or not at all, and described by a schema."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from refusals import refusal_of
from shots import POOL_TABLE, ball, random_break, scene_of

from ghostball.model import Ball, Physics, Scene, SceneError, Table
from ghostball.model.impact_laws import BALL_LAW_NAMES, CUSHION_LAW_NAMES
from ghostball.model.scene import json_schema
from ghostball.model.scene.toml import dumps

PLAIN = b'schema = 1\nname = "a"\n[[balls]]\nid = "cue"\nposition = [0.0, 0.0]\n'
WRONG_BALLS = b"".join(b'[[balls]]\nid = "%d"\nposition = [0, nan]\n' % i for i in range(1_000))
HEAP = b"".join(b'[[balls]]\nid = "%d"\nposition = [0, 0]\n' % i for i in range(1_000))

ODD_FILES = {
    "empty": (b"", "`schema` must be given"),
    "Latin-1": (PLAIN.replace(b'"cue"', b'"k\xf6"'), "not UTF-8 text (byte 39)"),
    "half a character": (PLAIN + "# ö".encode()[:-1], "not UTF-8"),
    "UTF-16": (PLAIN.decode().encode("utf-16"), "not UTF-8"),
    "zeros": (bytes(10_000), "not valid TOML"),
    "brackets": (b"a = " + b"[" * 100_000, "nested too deeply"),
    "tables": (PLAIN + b"[" + b"a." * 5_000 + b"a]\n", "not a known field"),
    "digits": (b"t_max = 1" + b"0" * 5_000 + b"\n" + PLAIN, "digits"),
    "a long word": (b"x" * 1_000_000, "not valid TOML"),
    "a mistake 1000 times": (PLAIN + WRONG_BALLS, "980 more mistakes"),
    "1000 balls at one place": (PLAIN + HEAP, "overlap by"),
}


@pytest.mark.parametrize("what", ODD_FILES)
def test_a_file_that_is_no_scene_is_refused_and_none_is_read_for_ever(what, tmp_path):
    content, says = ODD_FILES[what]
    path = tmp_path / "odd.toml"
    path.write_bytes(content)
    message = refusal_of(lambda: Scene.load(path))
    assert message.startswith(f"{path}:")
    assert says in message


def test_what_is_no_file_is_refused(tmp_path):
    for path, says in (
        (tmp_path / "missing.toml", "can't read the scene: No such file"),
        (tmp_path, "can't read the scene: Is a directory"),
        (Path("a\0b"), "can't read the scene: embedded null byte"),
    ):
        assert says in refusal_of(lambda path=path: Scene.load(path))
    assert "missing.toml" in refusal_of(lambda: Scene.load(tmp_path / "missing.toml"))


class TestSave:
    @pytest.mark.parametrize("seed", range(4))
    def test_load_reads_back_an_equal_scene_to_the_last_bit(self, seed, tmp_path):
        scene = random_break(seed, e=0.95, gravity=9.81 / 3.0, t_max=0.1 + 0.2)
        scene.save(tmp_path / "break.toml")
        read = Scene.load(tmp_path / "break.toml")
        assert read == scene
        assert read.positions.tobytes() == scene.positions.tobytes()
        assert read.velocities.tobytes() == scene.velocities.tobytes()
        assert [path.name for path in tmp_path.iterdir()] == ["break.toml"]

    def test_presets_write_only_what_differs(self):
        physics = Physics(preset="pool", ball_restitution=1.0)
        text = dumps(Scene(name="a", balls=[Ball(id="b", position=(0, 0))], physics=physics))
        section = text.split("[physics]\n")[1].split("\n\n")[0].strip().splitlines()
        assert section == ['preset = "pool"', "ball_restitution = 1.0"]
        assert Scene.loads(text).physics == physics

    def test_a_full_scene_survives(self):
        scene = Scene(
            name="full",
            title='Quotes "and" \\ and é and \n newline',
            tags=("a", "b"),
            t_max=1.5,
            table=Table(length=2, width=1, cushions=("right",)),
            physics=Physics(
                motion="sliding",
                airborne=True,
                impacts="sequential",
                ball_friction="alciatore",
                cushion="han2005",
                cushion_friction=0.14,
                cushion_height=0.028,
            ),
            balls=[
                Ball(id="x", position=(0.3, 0.3, 0.5), velocity=(1, 0, 2), radius=0.1, mass=2),
                Ball(id="y", position=(0.9, 0.3), angular_velocity=(1, 2, 3)),
                Ball(id="z", position=(1.5, 0.3), rolling_friction=0.1 / 3, sliding_friction=0),
                Ball(id="w", position=(1.8, 0.3), spinning_friction_rate=20 / 3),
            ],
        )
        read = Scene.loads(dumps(scene))
        assert read == scene
        for name in ("rolling_frictions", "sliding_frictions", "spinning_friction_rates", "rolls"):
            assert getattr(read, name).tobytes() == getattr(scene, name).tobytes()

    @pytest.mark.parametrize("airborne", [False, True])
    def test_a_strike_is_written_as_it_was_typed(self, airborne):
        typed = {"speed": 2.5, "direction": 0.1 + 0.2, "elevation": 0.4, "offset_up": -0.1 / 3.0}
        balls = [Ball(id="cue", position=(0, 0), strike=typed), Ball(id="b", position=(1, 0))]
        scene = Scene(name="a", balls=balls, physics=Physics(motion="sliding", airborne=airborne))
        text = dumps(scene)
        for field, value in typed.items():
            assert f"{field} = {value}" in text
        for other in ("velocity", "cue_mass", "squirt"):
            assert other not in text
        read = Scene.loads(text)
        again = Scene.model_validate_json(scene.model_dump_json(by_alias=True))
        assert repr(read) == repr(again) == repr(scene)
        assert read.velocities.tobytes() == scene.velocities.tobytes()

    def test_what_a_ball_takes_from_the_scene_is_not_written(self):
        # Otherwise editing the scene's friction in the file would have no effect.
        text = dumps(scene_of(ball((0, 0)), rolling_friction=0.03))
        assert text.count("friction") == text.count("rolling_friction = 0.03") == 1
        # A ball's own friction is written even if it equals the scene's.
        text = dumps(scene_of(ball((0, 0), sliding_friction=0.2)))
        assert text.split("[[balls]]")[1].count("sliding_friction = 0.2") == 1

    @pytest.mark.parametrize("preset", ["paper", "pool"])
    @pytest.mark.parametrize("cushion", CUSHION_LAW_NAMES)
    @pytest.mark.parametrize("ball_impact", BALL_LAW_NAMES)
    @pytest.mark.parametrize("impacts", ["simultaneous", "sequential"])
    def test_every_choice_of_laws_survives(self, preset, cushion, ball_impact, impacts):
        # This includes constants of the preset that have no effect with another law.
        laws = {"cushion": cushion, "ball_impact": ball_impact, "impacts": impacts}
        physics = Physics(preset=preset, motion="sliding", **laws)
        balls = [Ball(id="a", position=(0.5, 0.5)), Ball(id="b", position=(1, 0.5))]
        scene = Scene(name="laws", balls=balls, physics=physics, table=POOL_TABLE)
        assert Scene.loads(dumps(scene)) == scene

    def test_failing_leaves_nothing_behind_and_keeps_what_was_there(self, tmp_path):
        scene = scene_of(ball((0, 0)))
        (tmp_path / "file").write_text("kept")
        (tmp_path / "folder").mkdir()
        (tmp_path / "folder" / "inside").write_text("kept")
        for target in (
            tmp_path / "missing" / "a.toml",
            tmp_path / "folder",
            tmp_path / "file" / "a.toml",  # a folder of the path is a file
            tmp_path / ("n" * 300 + ".toml"),
        ):
            with pytest.raises(SceneError, match="can't write the scene"):
                scene.save(target)
        assert sorted(path.name for path in tmp_path.rglob("*")) == ["file", "folder", "inside"]
        assert (tmp_path / "file").read_text() == "kept"
        for target in ("", "/", "a\0b"):
            with pytest.raises(SceneError, match="can't write the scene"):
                scene.save(target)

    def test_an_interrupted_write_leaves_the_old_file_whole(self, tmp_path, monkeypatch):
        path = tmp_path / "scene.toml"
        scene_of(ball((0, 0), (1, 0))).save(path)
        before = path.read_bytes()

        def full_disk(self, *args, **kwargs):
            with Path.open(self, "wb") as file:
                file.write(b"half")
            raise OSError(28, "No space left on device")

        monkeypatch.setattr(Path, "write_bytes", full_disk)
        with pytest.raises(SceneError, match="No space left on device"):
            scene_of(ball((0, 0))).save(path)
        assert path.read_bytes() == before
        assert [entry.name for entry in tmp_path.iterdir()] == ["scene.toml"]


def test_the_json_schema_lists_what_may_be_chosen_and_explains_every_field():
    defined = json.loads(json_schema())["$defs"]
    physics, a_ball = defined["Physics"]["properties"], defined["Ball"]["properties"]
    assert physics["cushion"]["enum"] == list(CUSHION_LAW_NAMES)
    assert physics["ball_impact"]["enum"] == list(BALL_LAW_NAMES)
    assert physics["impacts"]["enum"] == ["simultaneous", "sequential", "compliant"]
    unexplained = {name for name, field in (physics | a_ball).items() if "description" not in field}
    assert unexplained <= {"preset"}
    own = {"rolling_friction", "sliding_friction", "spinning_friction_rate"}
    assert own <= set(a_ball) & set(physics)
    assert not own & set(defined["Ball"]["required"])
