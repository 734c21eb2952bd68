"""Scenes with one mistake each, made by hypothesis; what refuses one must say which it is.

A generator that spoils a valid scene in one way knows the right answer beforehand: which field, of
which value, breaks which rule, and on which line of its file. What a mistake is said to be here is
written out from the documentation of scenes, not read from the code that checks them.
"""

from __future__ import annotations

import copy
import datetime
import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from hypothesis import strategies as st

Location = tuple[str | int, ...]
Fields = dict[str, Any]


@dataclass(frozen=True)
class Malformed:
    """A scene with a mistake.

    Attributes
    ----------
    data : dict
        The whole scene as plain values.
    at : tuple of str and int
        The field to blame.
    tells : tuple of str
        What one line of the message must hold: the field's name, the rule, the value.
    plain : bool
        Whether TOML can say it too; else only Python can.
    """

    data: Fields
    at: Location
    tells: tuple[str, ...]
    plain: bool = True

    def text(self) -> tuple[str, int]:
        """Return the scene as TOML, and the line on which it must be blamed."""
        return written(self.data, self.at)

    def __str__(self) -> str:
        return f"{_name(self.at)} of {short(self.data)}"


def short(value: object) -> str:
    """Return how a value is shown in a fault."""
    shown = repr(value)
    return shown if len(shown) <= 400 else shown[:397] + "..."


def _name(at: Location) -> str:
    """Return a field's name as messages have it, such as "balls[0].radius"."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in at)
    return text.removeprefix(".")


# Scenes that are in order.

PLACES = [(0.2 + 0.25 * column, 0.2 + 0.25 * row) for row in range(3) for column in range(6)]
"""Where balls of up to 0.1 m don't touch each other, nor the cushions of the table below."""

_PHYSICS: list[Fields] = [
    {},
    {"preset": "paper", "rolling_friction": 0.03, "ball_restitution": 0.9},
    {"preset": "paper", "cushion": "restitution", "cushion_restitution": 0.7, "gravity": 3.7},
    {"preset": "pool"},
    {"preset": "pool", "ball_friction": 0.06, "cushion": "mathavan2010", "sliding_friction": 0.3},
    {"motion": "sliding", "cushion": "frictional", "cushion_friction": 0.1},
    {"motion": "sliding", "ball_impact": "mathavan2014", "spinning_friction_rate": 5},
]

_SPEEDS = st.floats(-3.0, 3.0).map(lambda v: round(v, 6))


@st.composite
def well_formed(draw: st.DrawFn, table: bool | None = None, most: int = 4) -> Fields:
    """Return a valid scene as plain values: some balls that move, on a table or none."""
    places = draw(st.permutations(PLACES))
    physics = draw(st.sampled_from(_PHYSICS))
    slides = physics.get("motion") == "sliding" or physics.get("preset") == "pool"
    balls = []
    for i in range(draw(st.integers(2, most))):
        one: Fields = {"id": f"ball {i}", "position": list(places[i])}
        if draw(st.booleans()):
            one["velocity"] = [draw(_SPEEDS), draw(_SPEEDS)]
        if slides and draw(st.booleans()):
            one["angular_velocity"] = [draw(_SPEEDS) for _ in "xyz"]
        if draw(st.booleans()):
            one |= {"radius": draw(st.sampled_from([0.028575, 0.03, 0.05]))}
            one |= {"mass": draw(st.sampled_from([0.17, 1, 0.05]))}
        balls.append(one)
    scene: Fields = {"schema": 1, "name": "generated", "t_max": 0.5, "physics": dict(physics)}
    if table or (table is None and draw(st.booleans())):
        scene["table"] = {"length": 2.0, "width": 1.0}
        if draw(st.booleans()):
            scene["table"]["cushions"] = ["left", "top"]
    return scene | {"balls": balls}


# Mistakes: each takes a valid scene and spoils it.

Mistake = Callable[[st.DrawFn, Fields], Malformed]

POSITIVE, NOT_NEGATIVE, FRACTION, REAL = "positive", "not negative", "fraction", "real"

NUMBERS: Mapping[str, Mapping[str, str]] = {
    "": {"t_max": POSITIVE},
    "physics": {
        "gravity": POSITIVE,
        "rolling_friction": NOT_NEGATIVE,
        "sliding_friction": NOT_NEGATIVE,
        "spinning_friction_rate": NOT_NEGATIVE,
        "ball_restitution": FRACTION,
        "ball_friction": NOT_NEGATIVE,
        "cushion_restitution": FRACTION,
        "cushion_tangential_restitution": FRACTION,
        "cushion_friction": NOT_NEGATIVE,
        "cushion_height": POSITIVE,
        "air_drag": NOT_NEGATIVE,
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
}
"""Every field that is one number, and what it must be."""

_TOO_SMALL = {
    POSITIVE: [(0.0, "greater than 0"), (0, "greater than 0"), (-1.5, "greater than 0")],
    NOT_NEGATIVE: [(-1e-300, "at least 0"), (-1, "at least 0")],
    FRACTION: [(-0.01, "at least 0"), (1.0000001, "at most 1"), (2, "at most 1")],
    REAL: [(-1e51, "at least -1e+50")],
}
_NO_NUMBERS = [math.nan, math.inf, -math.inf]
_NO_FLOATS: list[Any] = ["1.0", "", True, [1.0], {"a": 1}, datetime.date(1979, 5, 27)]
_PYTHON_ONLY: list[Any] = [1j, b"1.0", object, {1.0}, (1.0,)]


def _wrong_number(draw: st.DrawFn, rule: str) -> tuple[Any, str, bool]:
    """Return what isn't a number of that kind, the rule that it breaks, and whether TOML has it."""
    kind = draw(st.sampled_from(["bound", "bound", "size", "not finite", "type", "python"]))
    if kind == "bound":
        value, broken = draw(st.sampled_from(_TOO_SMALL[rule]))
        return value, broken, True
    if kind == "size" and rule != FRACTION:
        large = draw(st.sampled_from([1.1e50, 1e308, 10**60]))
        tiny = (1e-51, "at least 1e-50"), (5e-324, "at least 1e-50")
        return (
            *draw(st.sampled_from(((large, "at most 1e+50"), *tiny * (rule == POSITIVE)))),
            True,
        )
    if kind == "type":
        return draw(st.sampled_from(_NO_FLOATS)), "must be a number", True
    if kind == "python":
        return draw(st.sampled_from(_PYTHON_ONLY)), "must be a number", False
    return draw(st.sampled_from(_NO_NUMBERS)), "finite number", True


def wrong_number(draw: st.DrawFn, scene: Fields) -> Malformed:
    """Give a field, or a component of a vector, what isn't a number as it should be."""
    if draw(st.booleans()):
        i = draw(st.integers(0, len(scene["balls"]) - 1))
        field = draw(st.sampled_from(["position", "velocity", "angular_velocity"]))
        axis = draw(st.integers(0, 1 if field == "position" else 2))
        value, rule, plain = _wrong_number(draw, REAL)
        vector: list[Any] = [0.5, 0.25, 0.0][: 2 if field == "position" else 3]
        vector[axis] = value
        scene["balls"][i][field] = vector
        at: Location = ("balls", i, field)
        return Malformed(scene, at, (f"`{_name((*at, axis))}`", rule, shown(value)), plain)
    section = draw(st.sampled_from(sorted(NUMBERS)))
    field = draw(st.sampled_from(sorted(NUMBERS[section])))
    value, rule, plain = _wrong_number(draw, NUMBERS[section][field])
    if field == "ball_friction" and value == "alciatore":
        value = "alciator"
    at = _place(draw, scene, section, field)
    _owner(scene, at)[field] = value
    return Malformed(scene, at, (f"`{_name(at)}`", rule, shown(value)), plain)


def shown(value: Any) -> str:
    """Return how a message shows a value that is short."""
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) > 10**40:
        return "got 1000"
    text = json.dumps(value) if isinstance(value, (str, bool)) else repr(value)
    return f"got {text}"[:60]


def _place(draw: st.DrawFn, scene: Fields, section: str, field: str) -> Location:
    if section == "balls":
        return "balls", draw(st.integers(0, len(scene["balls"]) - 1)), field
    if section:
        scene.setdefault(section, {"length": 2.0, "width": 1.0} if section == "table" else {})
        return section, field
    return (field,)


def _owner(scene: Fields, at: Location) -> Any:
    owner: Any = scene
    for part in at[:-1]:
        owner = owner[part]
    return owner


_CHOICES: Mapping[str, tuple[str, ...]] = {
    "preset": ("paper", "pool"),
    "motion": ("rolling", "sliding"),
    "impacts": ("simultaneous", "sequential"),
    "ball_impact": ("frictional", "mathavan2014"),
    "cushion": ("mirror", "restitution", "frictional", "han2005", "mathavan2010"),
}
"""Every field of the physics that is a choice."""


def wrong_choice(draw: st.DrawFn, scene: Fields) -> Malformed:
    """Choose what there isn't."""
    field = draw(st.sampled_from(sorted(_CHOICES)))
    value = draw(st.sampled_from(["never", "", "PAPER", " pool", "mirror ", 3, True, ["mirror"]]))
    scene["physics"][field] = value
    rules = (f"'{_CHOICES[field][0]}'", f"'{_CHOICES[field][-1]}'", shown(value))
    return Malformed(scene, ("physics", field), (f"`physics.{field}`", *rules))


_TEXTS: list[tuple[Location, Any, str]] = [
    (("name",), "Break", "lower case letters"),
    (("name",), "", "lower case letters"),
    (("name",), "über", "lower case letters"),
    (("name",), "a" * 65, "at most 64"),
    (("name",), "../../etc", "lower case letters"),
    (("name",), "a\nb", "lower case letters"),
    (("name",), 3, "text in quotes"),
    (("title",), ["a"], "text in quotes"),
    (("tags",), "smoke", "must be a list"),
    (("tags",), ["smoke", 7], "text in quotes"),
    (("balls", 0, "id"), "", "must not be empty"),
    (("balls", 1, "id"), "x" * 65, "at most 64 characters"),
    (("balls", 1, "id"), 7, "text in quotes"),
    (("schema",), 2, "must be 1"),
    (("schema",), True, "must be 1"),
    (("schema",), 1.0, "must be 1"),
    (("schema",), "1", "must be 1"),
    (("physics", "airborne"), "yes", "true or false"),
    (("physics", "airborne"), 1, "true or false"),
    (("physics",), 3, "table of fields"),
    (("physics",), [1], "table of fields"),
    (("table",), "pool", "table of fields"),
    (("table", "cushions"), "left", "must be a list"),
    (("table", "cushions"), ["north"], "'left'"),
    (("table", "cushions"), ["left", "left"], "each cushion once"),
    (("balls",), [], "at least 1 item"),
    (("balls",), "cue", "must be a list"),
    (("balls",), 8, "must be a list"),
    (("balls",), {"id": "a"}, "must be a list"),
    (("balls", 0, "position"), [0.2], "2 or 3 components"),
    (("balls", 0, "position"), [], "2 or 3 components"),
    (("balls", 1, "position"), [0.2, 0.2, 0.2, 0.2], "2 or 3 components"),
    (("balls", 0, "velocity"), 1.0, "must be a list"),
    (("balls", 0, "velocity"), [[1.0, 0.0]], "velocity[0]` must be a number"),
    (("balls", 0, "angular_velocity"), [1.0, 0.0], "angular_velocity[2]` must be given"),
    (("balls", 0, "angular_velocity"), [1.0] * 4, "at most 3 items"),
]


def wrong_type(draw: st.DrawFn, scene: Fields) -> Malformed:
    """Give a text, a list or a table something else, or one of a wrong size."""
    at, value, rule = draw(st.sampled_from(_TEXTS))
    if at[0] == "table" and len(at) > 1:
        scene.setdefault("table", {"length": 2.0, "width": 1.0})
    _owner(scene, at)[at[-1]] = copy.deepcopy(value)
    return Malformed(scene, at, (f"`{_name(at)}", rule))


def missing(draw: st.DrawFn, scene: Fields) -> Malformed:
    """Leave out what must be given."""
    scene.setdefault("table", {"length": 2.0, "width": 1.0})
    last = len(scene["balls"]) - 1
    at: Location = draw(
        st.sampled_from(
            [
                ("name",),
                ("balls",),
                ("table", "length"),
                ("table", "width"),
                ("balls", 0, "id"),
                ("balls", last, "position"),
            ]
        )
    )
    del _owner(scene, at)[at[-1]]
    return Malformed(scene, at, (f"`{_name(at)}` must be given",))


_KEYS = st.text("abcdefghijklmnopqrstuvwxyz_0123456789", min_size=1, max_size=90)
_KNOWN = {
    "length", "width", "cushions", "id", "position", "velocity", "angular_velocity", "name",
    "title", "tags", "schema", "schema_version", "physics", "table", "balls",
    *_CHOICES, "airborne", *(field for fields in NUMBERS.values() for field in fields),
}  # fmt: skip


def unknown(draw: st.DrawFn, scene: Fields) -> Malformed:
    """Add a field that there isn't: any word, or one with a letter too many."""
    section = draw(st.sampled_from(sorted(NUMBERS)))
    typos = [f"{field}s" for field in NUMBERS[section]]
    field = draw(st.sampled_from(typos) | _KEYS.filter(lambda key: key not in _KNOWN))
    at = _place(draw, scene, section, field)
    _owner(scene, at)[field] = draw(st.sampled_from([1, "x", [], {}]))
    named = _name((*at[:-1], field if len(field) <= 80 else field[:77]))
    return Malformed(scene, at, (f"`{named}", "is not a known field"))


def _overlap(draw: st.DrawFn, scene: Fields) -> Malformed:
    first, last = scene["balls"][0], scene["balls"][-1]
    reach = first.get("radius", 0.028575) + last.get("radius", 0.028575)
    depth = draw(st.sampled_from([1e-9, 1e-3, 0.01, reach]))
    x, y = first["position"]
    last["position"] = [x + reach - depth, y]
    at = ("balls", len(scene["balls"]) - 1, "position")
    tells = ("must not overlap", '"ball 0"', f'"{last["id"]}"', "`balls[0]`")
    return Malformed(scene, at, tells)


def _outside(draw: st.DrawFn, scene: Fields) -> Malformed:
    scene["table"] = {"length": 2.0, "width": 1.0}
    i = draw(st.integers(0, len(scene["balls"]) - 1))
    radius = scene["balls"][i].get("radius", 0.028575)
    beyond = draw(st.sampled_from([1e-9, 0.01, 5.0, 1e6]))
    place, side = draw(
        st.sampled_from(
            [
                ([radius - beyond, 0.9], "left"),
                ([2.0 - radius + beyond, 0.9], "right"),
                ([1.9, radius - beyond], "bottom"),
                ([1.9, 1.0 - radius + beyond], "top"),
            ]
        )
    )
    scene["balls"][i]["position"] = place
    tells = (f"`balls[{i}].position` must be inside the table", f"{side} cushion")
    return Malformed(scene, ("balls", i, "position"), tells)


def _twice(draw: st.DrawFn, scene: Fields) -> Malformed:
    i = draw(st.integers(1, len(scene["balls"]) - 1))
    scene["balls"][i]["id"] = "ball 0"
    return Malformed(
        scene, ("balls", i, "id"), (f"`balls[{i}].id` must be unique", '"ball 0"', "`balls[0]`")
    )


def _off_cloth(draw: st.DrawFn, scene: Fields) -> Malformed:
    one = scene["balls"][0]
    if draw(st.booleans()):
        one["position"] = [*one["position"], 0.5]
        return Malformed(
            scene, ("balls", 0, "position"), ("`balls[0].position` z must be", "got 0.5 m")
        )
    one["velocity"] = [0.0, 0.0, -1.0]
    return Malformed(
        scene, ("balls", 0, "velocity"), ("`balls[0].velocity` z must be 0", "got -1.0 m/s")
    )


def _rolls(scene: Fields) -> None:
    scene["physics"] = {}
    for one in scene["balls"]:
        one.pop("angular_velocity", None)


def _slips(_: st.DrawFn, scene: Fields) -> Malformed:
    _rolls(scene)
    scene["balls"][0]["angular_velocity"] = [0.0, 0.0, 1.0]
    at = ("balls", 0, "angular_velocity")
    return Malformed(scene, at, ("`balls[0].angular_velocity` must be that of rolling",))


def _endless(draw: st.DrawFn, scene: Fields) -> Malformed:
    _rolls(scene)
    del scene["t_max"]
    for one in scene["balls"]:
        one.pop("velocity", None)
    scene["balls"][0]["velocity"] = [1.0, 0.0]
    field = draw(st.sampled_from(["balls", "physics"]))
    (scene["physics"] if field == "physics" else scene["balls"][1])["rolling_friction"] = 0
    return Malformed(scene, ("balls", 0), ("`t_max` must be given", "`rolling_friction` = 0.0"))


def _ignored(_: st.DrawFn, scene: Fields) -> Malformed:
    scene["physics"] = {"motion": "sliding", "cushion_height": 0.02}
    at = ("physics", "cushion_height")
    return Malformed(scene, at, ("`cushion_height` = 0.02 has no effect", '`cushion` = "mirror"'))


def _needs_spin(_: st.DrawFn, scene: Fields) -> Malformed:
    _rolls(scene)
    scene["physics"] = {"ball_friction": 0.06}
    at = ("physics", "ball_friction")
    return Malformed(scene, at, ('`motion` must be "sliding"', "`ball_friction` = 0.06"))


def _low_ball(_: st.DrawFn, scene: Fields) -> Malformed:
    scene["table"] = {"length": 2.0, "width": 1.0}
    scene["physics"] = {"preset": "pool"}
    scene["balls"][1]["radius"] = 0.01
    at = ("physics", "cushion_height")
    return (
        Malformed(scene, ("physics",), ("`cushion_height` must be less", "`balls[1]`"))
        if (at[1] not in scene["physics"])
        else Malformed(scene, at, ("`cushion_height` must be less",))
    )


def _unresolved(draw: st.DrawFn, scene: Fields) -> Malformed:
    scene.pop("table", None)
    far = draw(st.sampled_from([1e15, -1e20, 1e50]))
    scene["balls"][1]["position"] = [0.0, far]
    at = ("balls", 1, "position")
    return Malformed(scene, at, ("`balls[1].position` must be known", "double precision"))


RELATIONS: tuple[Mistake, ...] = (
    _overlap,
    _outside,
    _twice,
    _off_cloth,
    _slips,
    _endless,
    _ignored,
    _needs_spin,
    _low_ball,
    _unresolved,
)


def broken_relation(draw: st.DrawFn, scene: Fields) -> Malformed:
    """Break a rule between fields."""
    mistake = draw(st.sampled_from(RELATIONS))
    return mistake(draw, scene)


MISTAKES: Mapping[str, Mistake] = {
    "numbers": wrong_number,
    "choices": wrong_choice,
    "types": wrong_type,
    "missing": missing,
    "unknown": unknown,
    "relations": broken_relation,
}


@st.composite
def malformed(draw: st.DrawFn, kind: str) -> Malformed:
    """Return a scene with a mistake of that kind."""
    return MISTAKES[kind](draw, copy.deepcopy(draw(well_formed())))


# Scenes as text.


def literal(value: Any) -> str:
    """Return a value as TOML has it, on one line."""
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {literal(item)}" for key, item in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(literal, value)) + "]"
    return str(value)  # nan, inf, 1e+50, 1979-05-27


def written(scene: Fields, at: Location = ()) -> tuple[str, int]:
    """Return a scene as TOML, and the line of `at`: its own, or of the nearest part around it.

    0 where there is no such part.
    """
    lines: list[str] = []
    best, depth = 0, 0

    def put(line: str, *location: str | int) -> None:
        nonlocal best, depth
        lines.append(line)
        if depth < len(location) <= len(at) and at[: len(location)] == location:
            best, depth = len(lines), len(location)

    def put_all(fields: Fields, *location: str | int) -> None:
        for key, value in fields.items():
            put(f"{key} = {literal(value)}", *location, key)

    tables = {key for key in ("physics", "table") if isinstance(scene.get(key), dict)}
    balls = scene.get("balls")
    listed = isinstance(balls, list) and balls and all(isinstance(one, dict) for one in balls)
    put_all({k: v for k, v in scene.items() if k not in tables and not (listed and k == "balls")})
    for key in sorted(tables):
        put("", *())
        put(f"[{key}]", key)
        put_all(scene[key], key)
    for i, one in enumerate(balls if listed and isinstance(balls, list) else ()):
        put("", *())
        put("[[balls]]", "balls", i)
        put_all(one, "balls", i)
    return "\n".join(lines) + "\n", best


@st.composite
def bad_syntax(draw: st.DrawFn) -> tuple[str, int]:
    """Return a scene whose text isn't TOML, and the line on which that shows."""
    text, _ = written(draw(well_formed(table=True)))
    lines = text.splitlines()
    keys = [n for n, line in enumerate(lines) if " = " in line]
    n = draw(st.sampled_from(keys))
    spoilt = draw(
        st.sampled_from(
            [
                lines[n].replace(" = ", " = = ", 1),
                lines[n].replace(" = ", " ", 1),
                lines[n] + " ]",
                lines[n] + " x",
                lines[n] + " \x01",
                lines[n].split(" = ")[0] + " =",
                lines[n].split(" = ")[0] + " = 01",
                lines[n].split(" = ")[0] + " = 1__0",
                lines[n].split(" = ")[0] + ' = "\\q"',
                lines[n].split(" = ")[0] + ' = "open',
                lines[n].split(" = ")[0] + " = 1979-13-41",
                "[open",
                "= 1",
            ]
        )
    )
    lines[n] = spoilt
    return "\n".join(lines) + "\n", n + 1


@st.composite
def cut_text(draw: st.DrawFn) -> tuple[bytes, bytes]:
    """Return a scene file, and what is left of it when it is cut short."""
    text, _ = written(draw(well_formed()))
    whole = text.replace("ball 1", "böll 1").encode()
    return whole, whole[: draw(st.integers(0, len(whole) - 1))]


ANYTHING = st.one_of(
    st.binary(max_size=200),
    st.text(max_size=200).map(lambda text: text.encode("utf-8", "surrogatepass")),
    st.text("[]{}=\"'.#\n\\ a1_-", max_size=100).map(str.encode),
)
"""Bytes that are no scene: any, any text, and what looks a little like TOML."""
