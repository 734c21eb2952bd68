"""Pictures of scenes and results in a notebook: functions that `ghostball.reports` registers.

The model draws nothing itself, and imports nothing that does.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

VIEWS: dict[type, Callable[[Any], str]] = {}
"""The function that draws an object of a type, as SVG or HTML."""


def view_of(shown: object) -> str | None:
    """Return an object's picture; None, for which a notebook shows text, if none is registered."""
    draw = VIEWS.get(type(shown))
    return None if draw is None else draw(shown)
