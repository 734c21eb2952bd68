"""Each mistake in a scene file gives one line with file, line, field and value, for any input."""

from __future__ import annotations

import copy
import tempfile
from pathlib import Path

import pytest
import tomli_w
from hypothesis import given, strategies as st
from refusals import loading as refusal, refusal_of
from shots import POOL_TABLE

from ghostball.model import Scene, SceneError
from ghostball.model.impact_laws import BALL_LAW_NAMES, CUSHION_LAW_NAMES
from ghostball.model.scene.toml import dumps

VALID = """\
schema = 1
name = "half-ball"
title = "Half-ball cut"
tags = ["smoke"]

[physics]
preset = "paper"
rolling_friction = 0.01

[table]
length = 2.54
width = 1.27

[[balls]]
id = "cue"
position = [0.6, 0.635]
velocity = [2.0, 0.0]

[[balls]]
id = "object"
position = [1.2, 0.66]
"""


def edited(old: str, new: str) -> str:
    assert VALID.count(old) == 1
    return VALID.replace(old, new)


LAID_OUT = """\
schema = 1
name = "laid-out"
title = \'\'\'
[physics]
gravity = 0
\'\'\'
tags = [
  "a", # ]
  "physics.gravity = 1",
]
physics.gravity = 9.8
"physics"."ball_restitution" = 1.0 # a comment
[ 'table' ] # the cloth
length = 2.54
width = 1.27
[["balls"]]
id = "[[balls]]"
"position" = [
  0.5,
  0.5,
]
[[balls]] # second
'id' = "b"
position = [1.0, 0.5]
"""


def test_what_is_broken_below_is_valid():
    scene = Scene.loads(VALID)
    assert (scene.name, scene.physics.rolling_friction) == ("half-ball", 0.01)
    assert scene.table == POOL_TABLE
    assert [b.id for b in scene.balls] == ["cue", "object"]
    Scene.loads(LAID_OUT)


def laid_out(old: str, new: str) -> str:
    assert LAID_OUT.count(old) == 1
    return LAID_OUT.replace(old, new)


UNKNOWN = ("mirror", "str", "float", '"a[b]"', '"a(b)"', '""', '"x.y"')
BREAKS = ("\\n", "\\r", "\\u2028", "\\u0085", "\\f")
MISTAKES = {
    "an unknown field": edited("rolling_friction = 0.01", "roling_friction = 0.01"),
    "no number": edited("velocity = [2.0, 0.0]", "velocity = [nan, 0.0]"),
    "an overlap": edited("[1.2, 0.66]", "[0.62, 0.66]"),
    "outside the table": edited("[1.2, 0.66]", "[3.2, 0.66]"),
    "one name twice": edited('id = "object"', 'id = "cue"'),
    "in the air": edited("[1.2, 0.66]", "[1.2, 0.66, 1]"),
    "upwards": edited("[2.0, 0.0]", "[2.0, 0.0, 1]"),
    "a nose above a ball": edited('"paper"', '"pool"').replace("0.66]", "0.66]\nradius = 0.01"),
    "another spin": edited("[2.0, 0.0]", "[2.0, 0.0]\nangular_velocity = [0, 0, 1]"),
    "no end": edited("= 0.01", "= 0"),
    "two mistakes": edited("length = 2.54", "length = 0").replace("[2.0, 0.0]", "[nan, 0.0]"),
    # Python refuses to read more than 4300 decimal digits, and to print as many digits of a number
    # that it read in hexadecimal.
    "a number too long": edited("[1.2, 0.66]", f"[{'1' * 5000}, 0.66]"),
    "a hexadecimal number too long": edited("[1.2, 0.66]", f"[0x{'f' * 5000}, 0.66]"),
    "nested too deeply": VALID + f"radius = {'[' * 3000}{']' * 3000}\n",
    # Dotted keys nest without brackets: the parser can read these, `repr` can't write them.
    "nested by dots": edited('title = "Half-ball cut"', f"title.{'.'.join('a' * 2000)} = 1"),
    **{
        f"unknown key {key} of the {part}": edited(above, f"{above}{key} = 1\n")
        for key in UNKNOWN
        for part, above in (
            ("scene", "schema = 1\n"),
            ("physics", "[physics]\n"),
            ("ball", 'id = "cue"\n'),
        )
    },
    **{
        f"a name with {separator} twice": edited('id = "cue"', f'id = "a{separator}b"').replace(
            'id = "object"', f'id = "a{separator}b"'
        )
        for separator in BREAKS
    },
    "a dotted key": laid_out("gravity = 9.8", "gravity = -9.8"),
    "a quoted key": laid_out("= 1.0 #", "= 1.5 #"),
    "in a table with spaces": laid_out("length = 2.54", "length = 0"),
    "left out of a table": laid_out("width = 1.27", ""),
    "in a list over lines": laid_out("  0.5,\n]", '  "a",\n]'),
    "in a second table": laid_out('"b"', '""'),
    "a dotted unknown key": laid_out("[1.0, 0.5]", "[1.0, 0.5]\nspin.x = 1"),
    "a table in a ball": laid_out("[1.0, 0.5]", "[1.0, 0.5]\n[balls.mass]\nx = 1"),
}


@pytest.mark.parametrize("what", MISTAKES)
def test_a_mistake_is_described_with_file_line_field_and_value(what, snapshot):
    message = refusal(MISTAKES[what])
    assert all(line.startswith("shot.toml:") for line in message.splitlines())
    assert message == snapshot


CHOICES = {
    "pol": {"physics": {"preset": "pol"}},
    "Pool": {"physics": {"preset": "Pool"}},
    "ice": {"physics": {"preset": "ice"}},
    "slide": {"physics": {"motion": "slide"}},
    "han2010": {"physics": {"cushion": "han2010"}},
    "alciatori": {"physics": {"ball_friction": "alciatori"}},
    "wpa9ft": {"table": "wpa9ft"},
    "botom": {"table": {"length": 1.0, "width": 1.0, "cushions": ["botom"]}},
}
JSON = {
    "cut short": '{"name": 1',
    "a list": "[]",
    "NaN": '{"name": "a", "balls": [{"id": "a", "position": [0, NaN]}]}',
    "a key": '{"name": "a", "ball": []}',
    "no text": b"\xff",
}


@pytest.mark.parametrize("wrong", CHOICES)
def test_a_misspelt_choice_asks_whether_the_closest_was_meant_or_names_all(wrong, snapshot):
    ball = {"id": "a", "position": (0.5, 0.5)}
    scene = {"name": "a", "balls": [ball], **CHOICES[wrong]}
    assert refusal_of(lambda: Scene.model_validate(scene)) == snapshot


@pytest.mark.parametrize("wrong", JSON)
def test_json_is_refused_as_all_else_is(wrong, snapshot):
    assert refusal_of(lambda: Scene.model_validate_json(JSON[wrong])) == snapshot


VALID_LINES = VALID.splitlines()

SPOILT = [
    *(
        "{key} = = {value}",
        "{key} {value}",
        "{line} ]",
        "{line} x",
        "{line} \x01",
        "{key} =",
        "= 1",
    ),
    *(
        "{key} = 01",
        "{key} = 1__0",
        '{key} = "\\q"',
        '{key} = "open',
        "{key} = 1979-13-41",
        "[open",
    ),
    "{line}\n{line}",
]


@pytest.mark.parametrize("spoilt", SPOILT)
def test_a_syntax_error_is_described_with_its_line(spoilt):
    for n, line in enumerate(VALID_LINES):
        key, _, value = line.partition(" = ")
        if not value:
            continue
        wrong = spoilt.format(key=key, value=value, line=line)
        message = refusal("\n".join([*VALID_LINES[:n], wrong, *VALID_LINES[n + 1 :], ""]))
        # An unclosed value, or a key that is given twice, is detected in the next line.
        places = [f"shot.toml:{n + 1 + k}: not valid TOML: " for k in (0, 1)]
        assert message.startswith(tuple(places)), message


def test_a_file_cut_short_anywhere_is_refused_or_read_as_what_is_left_of_it(tmp_path):
    path = tmp_path / "shot.toml"
    whole = VALID.replace('"object"', '"öbject"').encode()
    right = Scene.loads(whole.decode())
    read = 0
    for size in range(len(whole)):
        path.write_bytes(whole[:size])
        scene, refused = scene_or_refusal(lambda: Scene.load(path))
        if scene is None:
            assert refused.startswith(f"{path}:"), refused
        else:
            read += 1
            assert (
                scene.balls[:-1] == right.balls[: len(scene.balls) - 1]
            )  # the last ball may lack lines
    assert 0 < read < 100


@given(
    st.one_of(
        st.binary(max_size=200),
        st.text(max_size=200).map(lambda text: text.encode("utf-8", "surrogatepass")),
        st.text("[]{}=\"'.#\n\\ a1_-", max_size=100).map(str.encode),
    )
)
def test_bytes_that_are_no_scene_are_refused(content):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shot.toml"
        path.write_bytes(content)
        assert refusal_of(lambda: Scene.load(path)).startswith(f"{path}:")


VALUES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(2**70), 2**70),
    st.floats(),
    st.sampled_from(["sliding", "pool", *CUSHION_LAW_NAMES, *BALL_LAW_NAMES]),
    st.sampled_from([0.0, -0.0, 1e308, -1e308, 5e-324, 1e-300, 10**400]),
    st.text(max_size=5),
    st.lists(st.one_of(st.floats(), st.text(max_size=2), st.booleans()), max_size=4),
    st.dictionaries(st.text(max_size=5), st.integers(), max_size=2),
    st.dates(),
    st.fixed_dictionaries({"speed": st.just(2.0), "direction": st.floats(-7.0, 7.0)}),
)
FIELDS = [
    *("schema", "name", "tags", "t_max", "physics", "table", "balls", "id", "position"),
    *("velocity", "radius", "mass", "angular_velocity", "motion", "cushion", "preset"),
    *("mirror", "float", "str", "ball_friction", "ball_restitution", "airborne", "cushions"),
    *("rolling_friction", "sliding_friction", "spinning_friction_rate", "impacts", "ball_impact"),
    *("cushion_friction", "cushion_height", "cushion_restitution"),
    *("cushion_restitution_loss", "strike", "elevation"),
]
KEYS = st.one_of(st.text(max_size=6), st.sampled_from(FIELDS))


@st.composite
def mutated_scenes(draw):
    """Return a valid scene's dict with one to three values replaced, added or removed."""
    data = copy.deepcopy(Scene.loads(VALID).model_dump(mode="json", by_alias=True))
    for ball_fields in data["balls"]:
        del ball_fields["angular_velocity"]
    del data["t_max"]
    for _ in range(draw(st.integers(1, 3))):
        place = draw(st.sampled_from(["scene", "physics", "table", "ball"]))
        owner = data if place == "scene" else data.get("balls" if place == "ball" else place)
        if place == "ball" and isinstance(owner, list) and owner:
            owner = draw(st.sampled_from(owner))
        if not isinstance(owner, dict):
            continue
        if owner and draw(st.booleans()):
            key = draw(st.sampled_from(sorted(owner)))
            if draw(st.booleans()):
                del owner[key]
                continue
        else:
            key = draw(KEYS)
        owner[key] = draw(VALUES)
    return data


def without_nones(value):
    if isinstance(value, dict):
        return {k: without_nones(v) for k, v in value.items() if v is not None}
    if isinstance(value, list):
        return [without_nones(v) for v in value if v is not None]
    return value


def scene_or_refusal(make) -> tuple[Scene | None, str]:
    """Return the scene, or the message of the `SceneError`; any other error is a bug."""
    try:
        return make(), ""
    except SceneError as error:
        return None, str(error)


@given(mutated_scenes())
def test_any_mutation_loads_or_is_refused_as_a_scene_error(data):
    text = tomli_w.dumps(without_nones(data))
    scene, refused = scene_or_refusal(lambda: Scene.loads(text, "mutated.toml"))
    if scene is None:
        assert all(line.startswith("mutated.toml") for line in refused.split("\n"))
    else:
        assert Scene.loads(dumps(scene)) == scene
