"""Scenes as plain values: in order or with a mistake, as text with known lines, as messages say."""

from __future__ import annotations

import json
from collections.abc import Callable
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
        return f"{name_of(self.at)} of {short(self.data)}"


Mistake = Callable[[st.DrawFn, Fields], Malformed]
"""Takes a valid scene and spoils it."""


def short(value: object) -> str:
    """Return how a value is shown in a fault."""
    shown = repr(value)
    return shown if len(shown) <= 400 else shown[:397] + "..."


def name_of(at: Location) -> str:
    """Return a field's name as messages have it, such as "balls[0].radius"."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in at)
    return text.removeprefix(".")


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


def shown(value: Any) -> str:
    """Return how a message shows a value that is short."""
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) > 10**40:
        return "got 1000"
    text = json.dumps(value) if isinstance(value, (str, bool)) else repr(value)
    return f"got {text}"[:60]


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
