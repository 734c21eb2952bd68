"""Every kind of mistake in every field of a scene is refused with field, rule and value.

The expected rules are copied from the documentation of scenes, not from the code that checks them.
Each mistake is made in a valid scene: as plain values, as arguments, and as text if TOML can
express the mistake.
"""

from __future__ import annotations

import copy
import datetime
import itertools
import json
import math
from collections.abc import Iterator
from typing import Any

import pytest
import tomli_w
from refusals import loading, refusal_of

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Scene, Strike, Table

POSITIVE, NOT_NEGATIVE, FRACTION, REAL = "positive", "not negative", "fraction", "real"
CUE_SPEED, BETWEEN_1_AND_2 = "speed of a cue", "between 1 and 2"
MODULUS, POISSON = "Young's modulus", "Poisson's ratio"

NUMBERS = {
    "": {"t_max": POSITIVE},
    "physics": {
        "gravity": POSITIVE,
        "rolling_friction": NOT_NEGATIVE,
        "sliding_friction": NOT_NEGATIVE,
        "spinning_friction_rate": NOT_NEGATIVE,
        "ball_restitution": FRACTION,
        "ball_friction": NOT_NEGATIVE,
        "cushion_restitution": FRACTION,
        "cushion_restitution_loss": NOT_NEGATIVE,
        "cushion_tangential_restitution": FRACTION,
        "cushion_friction": NOT_NEGATIVE,
        "cushion_height": POSITIVE,
        "cushion_frequency_ratio": BETWEEN_1_AND_2,
        "air_drag": NOT_NEGATIVE,
        "rolling_friction_quadratic": NOT_NEGATIVE,
        "ball_youngs_modulus": MODULUS,
        "ball_poissons_ratio": POISSON,
        "table_restitution": FRACTION,
    },
    "table": {"length": POSITIVE, "width": POSITIVE},
    "balls": {
        "radius": POSITIVE,
        "mass": POSITIVE,
        "rolling_friction": NOT_NEGATIVE,
        "sliding_friction": NOT_NEGATIVE,
        "spinning_friction_rate": NOT_NEGATIVE,
    },
    "strike": {
        "speed": CUE_SPEED,
        "direction": REAL,
        "elevation": REAL,
        "offset_left": REAL,
        "offset_up": REAL,
        "cue_mass": POSITIVE,
        "tip_restitution": FRACTION,
        "tip_friction": NOT_NEGATIVE,
        "end_mass": POSITIVE,
    },
}
"""Every field with one number, and its rule."""

CHOICES = {
    "preset": ("paper", "pool"),
    "motion": ("rolling", "sliding"),
    "impacts": ("simultaneous", "sequential", "compliant"),
    "ball_impact": ("frictional", "mathavan2014"),
    "cushion": ("mirror", "restitution", "frictional", "han2005", "mathavan2010", "stronge2000"),
}
"""Every field of the physics that is a choice."""

VECTORS = ("position", "velocity", "angular_velocity")
"""Every field that is a vector."""


Location = tuple[str | int, ...]
"""Location of a field, such as ("balls", 0, "radius")."""


def name_of(at: Location) -> str:
    """Return a field's name as messages have it, such as "balls[0].radius"."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in at)
    return text.removeprefix(".")


# --- mistakes


def test_every_field_is_spoilt():
    # Fails if a new field of a scene has no test.
    assert set(Physics.model_fields) == {*NUMBERS["physics"], *CHOICES, "airborne"}
    assert set(Ball.model_fields) == {*NUMBERS["balls"], *VECTORS, "id", "strike"}
    assert set(Strike.model_fields) == {*NUMBERS["strike"], "squirt"}
    # test_table.py and test_table_rules.py test the shapes of tables.
    shapes = {"preset", "vertices", "pockets", "posts"}
    assert set(Table.model_fields) == {*NUMBERS["table"], "cushions", *shapes}
    # test_rack.py tests racks.
    texts = {"schema_version", "name", "title", "tags", "physics", "table", "rack", "balls"}
    assert set(Scene.model_fields) == {*NUMBERS[""], *texts}


# Valid scenes; each case makes a mistake in one of them.

PHYSICS: list[dict[str, Any]] = [
    {},
    {"preset": "paper", "rolling_friction": 0.03, "ball_restitution": 0.9},
    {"preset": "paper", "cushion": "restitution", "cushion_restitution": 0.7, "gravity": 3.7},
    {"preset": "pool"},
    {"preset": "pool", "ball_friction": 0.06, "cushion": "mathavan2010", "sliding_friction": 0.3},
    {"motion": "sliding", "cushion": "frictional", "cushion_friction": 0.1},
    {"motion": "sliding", "ball_impact": "mathavan2014", "spinning_friction_rate": 5},
]

BALLS: list[dict[str, Any]] = [
    {"id": "ball 0", "position": [0.2, 0.2], "velocity": [2.0, 1.25]},
    {"id": "ball 1", "position": [0.45, 0.2], "radius": 0.05, "mass": 1},
    {"id": "ball 2", "position": [0.7, 0.45], "velocity": [-1, 0.5], "radius": 0.03},
    {
        "id": "ball 3",
        "position": [1.2, 0.5],
        # The ball rolls at once, as some of the physics require.
        "strike": {"speed": 1, "direction": 0.5, "offset_up": 0.4, "squirt": "none"},
    },
]

SCENES = [
    {"schema": 1, "name": "plain", "t_max": 0.5, "physics": physics, "table": table, "balls": BALLS}
    for physics in PHYSICS
    for table in (
        {"length": 2.0, "width": 1.0},
        {"length": 2.0, "width": 1.0, "cushions": ["left", "top"]},
    )
]


@pytest.mark.parametrize("data", SCENES, ids=str)
def test_what_is_spoilt_is_in_order(data):
    scene = Scene.loads(tomli_w.dumps(data))
    assert scene == Scene(**data) == Scene.model_validate(data)
    assert simulate(scene).status.complete


def assert_refused(
    scene: dict[str, Any], at: Location, value: Any, *tells: str, plain: bool = True
) -> None:
    """Assert that a valid scene with `value` at a location is refused; `LEFT_OUT`: without a value.

    One line of the message contains all of `tells`; for a text, the line starts with its location.
    `test_messages.py` tests the line numbers.
    """
    data = copy.deepcopy(scene)
    owner: Any = data
    for part in at[:-1]:
        owner = owner[part]
    if value is LEFT_OUT:
        del owner[at[-1]]
    else:
        owner[at[-1]] = value
    assert_described(refusal_of(lambda: Scene.model_validate(data)), tells)
    assert_described(refusal_of(lambda: Scene(**data)), tells)
    if plain:
        assert_described(loading(tomli_w.dumps(data)), tells, "shot.toml:")


LEFT_OUT = object()


def assert_described(message: str, tells: tuple[str, ...], place: str = "") -> None:
    lines = [line for line in message.splitlines() if line.startswith(place)]
    assert any(all(part in line for part in tells) for line in lines), (place, tells, message)


def shown(value: Any) -> str:
    """Return a short value as messages show it."""
    if isinstance(value, int) and abs(value) > 10**40:
        return "got 1000" if abs(value) < 10**300 else "got 0x"
    text = json.dumps(value) if isinstance(value, (str, bool)) else repr(value)
    return f"got {text}"[:60]


BEYOND = {
    POSITIVE: [
        *((value, "greater than 0") for value in (0.0, -0.0, 0, -1.5)),
        *((value, "at least 1e-50") for value in (1e-51, 5e-324)),
    ],
    NOT_NEGATIVE: [(value, "at least 0") for value in (-1e-300, -1)],
    BETWEEN_1_AND_2: [
        (1.0, "must be greater than 1"),
        (2.0, "must be less than 2"),
        (-1.5, "must be greater than 1"),
    ],
    FRACTION: [
        (-0.01, "at least 0"),
        *((value, "at most 1") for value in (math.nextafter(1.0, 2.0), 1.3, 2)),
    ],
    REAL: [(value, "at least -1e+50") for value in (-1.1e50, -1e300)],
    CUE_SPEED: [(0.0, "greater than 0"), (1e-51, "at least 1e-50"), (1.1e49, "at most 1e+49")],
    MODULUS: [(1e3, "at least 1e+06"), (2e13, "at most 1e+13")],
    POISSON: [(-0.1, "at least 0"), (0.51, "at most 0.5")],
}
"""Numbers beyond their bounds, and the rule that they break."""

NO_NUMBERS = [math.nan, math.inf, -math.inf]
NO_FLOATS = ["1.0", "", "ice", True, False, [1.0], {"a": 1}, datetime.date(1979, 5, 27)]
PYTHON_ONLY = [None, 1j, b"1.0", object, {1.0}, (1.0,)]
LARGE = [1.1e50, 1e308, 10**60, 10**400]


def wrong_numbers(rule: str) -> Iterator[tuple[Any, str, bool]]:
    """Yield invalid values, the rule that each breaks, and whether TOML can express the value."""
    yield from ((value, broken, True) for value, broken in BEYOND[rule])
    if rule not in (FRACTION, CUE_SPEED, BETWEEN_1_AND_2, MODULUS, POISSON):
        yield from ((value, "at most 1e+50", True) for value in LARGE)
    yield from ((value, "finite number", True) for value in NO_NUMBERS)
    yield from ((value, "must be a number", True) for value in NO_FLOATS)
    yield from ((value, "must be a number", False) for value in PYTHON_ONLY)


PLACES: dict[str, Location] = {
    "": (),
    "physics": ("physics",),
    "table": ("table",),
    "balls": ("balls", 2),
    "strike": ("balls", 3, "strike"),
}
"""Location of the fields of each part."""

PARTS = {"": Scene, "physics": Physics, "table": Table, "balls": Ball, "strike": Strike}
NEEDED = {
    "physics": {},
    "table": {"length": 1, "width": 1},
    "balls": {"id": "a", "position": (0, 0)},
    "strike": {"speed": 1, "direction": 0},
}


@pytest.mark.parametrize(
    ("part", "field"), [(part, field) for part, fields in NUMBERS.items() for field in fields]
)
def test_a_field_that_is_no_number_as_it_should_be(part, field):
    wrong = wrong_numbers(NUMBERS[part][field])
    for scene, (value, rule, plain) in zip(itertools.cycle(SCENES), wrong, strict=False):
        if value is None and PARTS[part].model_fields[field].default is None:
            continue  # counts as left out
        at = (*PLACES[part], field)
        assert_refused(scene, at, value, f"`{name_of(at)}`", rule, shown(value), plain=plain)
        if part:
            message = refusal_of(lambda value=value: PARTS[part](**{**NEEDED[part], field: value}))
            assert_described(message, (f"`{field}`", rule, shown(value)))


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("field", VECTORS)
def test_a_component_that_is_no_number_as_it_should_be(field, axis):
    for scene, (value, rule, plain) in zip(
        itertools.cycle(SCENES), wrong_numbers(REAL), strict=False
    ):
        vector: list[Any] = [0.5, 0.25, 0.0]
        vector[axis] = value
        at = ("balls", 1, field)
        tells = (f"`{name_of((*at, axis))}`", rule, shown(value))
        assert_refused(scene, at, vector, *tells, plain=plain)


@pytest.mark.parametrize("field", CHOICES)
def test_a_choice_that_there_is_not(field):
    choices = [f"'{choice}'" for choice in CHOICES[field]]
    wrong = ("never", "", "PAPER", "Mirror", " pool", "mirror ", 3, True, ["mirror"], None)
    for scene, value in zip(SCENES, wrong, strict=False):
        tells = (f"`physics.{field}`", *choices, "" if value is None else shown(value))
        assert_refused(scene, ("physics", field), value, *tells, plain=value is not None)


LOWER_CASE = "lower case letters"
NAMES = ("Break", "", "über", "../../etc", "a/b", "a b", "-a", "a\nb", "a\n")

WRONG: list[tuple[Location, Any, str]] = [
    *((("name",), name, LOWER_CASE) for name in NAMES),
    (("name",), "a" * 65, "at most 64"),
    (("name",), 3, "text in quotes"),
    (("title",), 3, "text in quotes"),
    (("title",), ["a"], "text in quotes"),
    (("tags",), "smoke", "must be a list"),
    (("tags",), ["smoke", 7], "text in quotes"),
    (("balls", 0, "id"), "", "must not be empty"),
    (("balls", 1, "id"), "x" * 65, "at most 64 characters"),
    (("balls", 1, "id"), 7, "text in quotes"),
    # Later versions will compare the schema, so true and 1.0 are refused today.
    *((("schema",), value, "must be 1") for value in (2, True, 1.0, "1")),
    (("physics", "airborne"), "yes", "true or false"),
    (("physics", "airborne"), 1, "true or false"),
    (("physics",), 3, "table of fields"),
    (("physics",), [1], "table of fields"),
    (("table",), "pool", "'wpa-9ft'"),
    (("table",), 3, "table of fields"),
    (("table", "preset"), 3, "'wpa-9ft'"),
    (("table", "vertices"), 3, "must be a list"),
    (("table", "vertices"), [[0, 0], [1, "x"], [0, 1]], "must be a number"),
    (("table", "vertices"), [[0, 0], [1], [0, 1]], "must be given"),
    (("table", "posts"), 3, "must be a list"),
    (("table", "posts"), [{"centre": [1.0, 0.5]}], "radius` must be given"),
    (("table", "pockets"), "round", "table of fields"),
    (("table", "pockets"), {"corner": {"mouth": 0.1}}, "corner.angle` must be given"),
    (("table", "cushions"), "left", "must be a list"),
    (("table", "cushions"), ["north"], "'left'"),
    (("table", "cushions"), ["left", "left"], "each cushion once"),
    (("balls",), [], "at least 1 item"),
    (("balls",), "cue", "must be a list"),
    (("balls",), 8, "must be a list"),
    (("balls",), {"id": "a"}, "must be a list"),
    (("balls", 0, "position"), [0.2], "2 or 3 components, got 1"),
    (("balls", 0, "position"), [], "2 or 3 components, got 0"),
    (("balls", 1, "position"), [0.2, 0.2, 0.2, 0.2], "2 or 3 components, got 4"),
    (("balls", 0, "velocity"), 1.0, "must be a list"),
    (("balls", 0, "velocity"), "fast", "must be a list"),
    (("balls", 0, "velocity"), datetime.date(1979, 5, 27), "must be a list"),
    (("balls", 0, "velocity"), [[1.0, 0.0]], "velocity[0]` must be a number"),
    (("balls", 0, "angular_velocity"), [1.0, 0.0], "angular_velocity[2]` must be given"),
    (("balls", 0, "angular_velocity"), [1.0] * 4, "at most 3 items"),
    (("balls", 3, "strike"), 2.0, "table of fields"),
    (("balls", 3, "strike"), [1.0, 0.0], "table of fields"),
    *(
        (("balls", 3, "strike", "squirt"), value, "'end-mass', 'alciatore' or 'none'")
        for value in ("", "A.31", True, 0.0)
    ),
]


@pytest.mark.parametrize(
    ("at", "value", "rule"), WRONG, ids=[f"{name_of(at)}={value}"[:40] for at, value, _ in WRONG]
)
def test_a_text_a_list_or_a_table_of_another_type_or_size(at, value, rule):
    for scene in SCENES:
        assert_refused(scene, at, value, f"`{name_of(at)}", rule)


@pytest.mark.parametrize(
    "at",
    [
        ("name",),
        ("balls",),
        ("table", "length"),
        ("table", "width"),
        ("balls", 0, "id"),
        ("balls", 2, "position"),
        ("balls", 3, "strike", "speed"),
        ("balls", 3, "strike", "direction"),
    ],
    ids=name_of,
)
def test_what_must_be_given_is_left_out(at):
    for scene in SCENES:
        assert_refused(scene, at, LEFT_OUT, f"`{name_of(at)}` must be given")


@pytest.mark.parametrize("part", NUMBERS)
def test_a_field_that_there_is_not(part):
    fields = [f"{field}s" for field in NUMBERS[part]]
    for field in (*fields, "x", "0", "self", "class", "k" * 80, "k" * 81, "k" * 10_000):
        for scene, value in zip(SCENES, (1, "x", [], {}), strict=False):
            at = (*PLACES[part], field)
            named = name_of((*PLACES[part], field if len(field) <= 80 else field[:77]))
            assert_refused(scene, at, value, f"`{named}", "is not a known field")
