"""The lines of a baseline's file: fields as TOML, and events as a person reads them."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from pydantic_core import PydanticCustomError

from ghostball.model import (
    EVENT_DTYPE,
    OBSTACLE_KINDS,
    EventKind,
    Events,
    event_dict,
    partner_index,
)


def line_of_event(event: Any) -> str:
    """Return an event as a person reads it: instant, kind, ball, other ball or cushion."""
    plain = event_dict(event)
    other = "" if plain["b"] is None else f" {plain['b']}"
    return f"{plain['t']!r} {plain['kind']} {plain['a']}{other}"


MOST_BALLS = 2**31
"""What an event can name, as `EVENT_DTYPE` holds it."""

_KINDS = {kind.label: kind for kind in EventKind}


def events_of_lines(lines: tuple[str, ...]) -> Events:
    """Read events back."""
    events = np.empty(len(lines), dtype=EVENT_DTYPE)
    for i, line in enumerate(lines):
        try:
            t, label, a, *rest = line.split()
            kind = _KINDS[label]
            if len(rest) != (kind is EventKind.BALL_BALL or kind in OBSTACLE_KINDS):
                raise ValueError
            b = -1
            if kind is EventKind.BALL_BALL:
                b = int(rest[0])
            elif kind in OBSTACLE_KINDS:
                b = partner_index(kind, rest[0])
            if not (0 <= int(a) < MOST_BALLS and b < MOST_BALLS):
                raise ValueError  # numpy below 2 would wrap it, with a warning
            events[i] = (float(t), int(kind), int(a), b)
        except (ValueError, KeyError, OverflowError):
            raise PydanticCustomError(
                "event",
                "`events.first[{i}]` must be an event such as '0.5 ball-ball 0 1', got {line}",
                {"i": i, "line": repr(line)},
            ) from None
    return events


def line_of(text: str, field: str) -> int:
    """Return the line of a field that stands before all tables, counted from 1."""
    found = re.search(rf"^\s*{field}\s*=", text, re.MULTILINE)
    return 1 if found is None else text.count("\n", 0, found.end()) + 1


def toml_lines(fields: Mapping[str, Any]) -> Iterator[str]:
    """Yield fields as TOML, a line each, and events a line each; a writer would spread bands."""
    for key, value in fields.items():
        if isinstance(value, tuple) and value and isinstance(value[0], str):
            yield f"{_key(key)} = ["
            yield from (f"    {_inline(one)}," for one in value)
            yield "]"
        else:
            yield f"{_key(key)} = {_inline(value)}"


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _inline(name)


def _inline(value: Any) -> str:
    """Return a value as TOML in one line; floats read back to the same bits."""
    if isinstance(value, dict):
        return (
            "{ " + ", ".join(f"{_key(key)} = {_inline(one)}" for key, one in value.items()) + " }"
        )
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_inline, value)) + "]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(value)
