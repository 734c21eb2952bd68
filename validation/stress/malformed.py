"""Scenes with one mistake each, made by hypothesis; what refuses one must say which it is.

A generator that spoils a valid scene in one way knows the right answer beforehand: which field, of
which value, breaks which rule, and on which line of its file. What a mistake is said to be here is
written out from the documentation of scenes, not read from the code that checks them.
"""

from __future__ import annotations

import copy
import datetime
import math
from collections.abc import Mapping
from typing import Any

from hypothesis import strategies as st

from validation.stress.broken_relations import broken_relation
from validation.stress.plain_scenes import (
    Fields,
    Location,
    Malformed,
    Mistake,
    name_of,
    shown,
    well_formed,
)

# Mistakes: each takes a valid scene and spoils it.

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
        return Malformed(scene, at, (f"`{name_of((*at, axis))}`", rule, shown(value)), plain)
    section = draw(st.sampled_from(sorted(NUMBERS)))
    field = draw(st.sampled_from(sorted(NUMBERS[section])))
    value, rule, plain = _wrong_number(draw, NUMBERS[section][field])
    at = _place(draw, scene, section, field)
    _owner(scene, at)[field] = value
    return Malformed(scene, at, (f"`{name_of(at)}`", rule, shown(value)), plain)


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
    return Malformed(scene, at, (f"`{name_of(at)}", rule))


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
    return Malformed(scene, at, (f"`{name_of(at)}` must be given",))


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
    named = name_of((*at[:-1], field if len(field) <= 80 else field[:77]))
    return Malformed(scene, at, (f"`{named}", "is not a known field"))


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
