"""Scenes as plain values, and as TOML of which the line of every field is known."""

from __future__ import annotations

import json
from typing import Any

Location = tuple[str | int, ...]
"""Where a field is, such as ("balls", 0, "radius")."""


def name_of(at: Location) -> str:
    """Return a field's name as messages have it, such as "balls[0].radius"."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in at)
    return text.removeprefix(".")


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


def written(scene: dict[str, Any], at: Location = ()) -> tuple[str, int]:
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

    def put_all(fields: dict[str, Any], *location: str | int) -> None:
        for key, value in fields.items():
            put(f"{key} = {literal(value)}", *location, key)

    tables = {key for key in ("physics", "table") if isinstance(scene.get(key), dict)}
    balls = scene.get("balls")
    listed = balls if isinstance(balls, list) and all(isinstance(b, dict) for b in balls) else []
    nested = tables | {"balls"} if listed else tables
    put_all({key: value for key, value in scene.items() if key not in nested})
    for key in sorted(tables):
        put(f"[{key}]", key)
        put_all(scene[key], key)
    for i, ball in enumerate(listed):
        put("[[balls]]", "balls", i)
        put_all(ball, "balls", i)
    return "\n".join(lines) + "\n", best
