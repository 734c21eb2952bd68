"""Registry of the functions that draw scenes and results in a notebook.

`ghostball.reports` registers the functions; the model imports no drawing code.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

VIEWS: dict[type, Callable[[Any], str]] = {}
"""For each type, the function that draws its objects as SVG or HTML."""


def view_of(shown: object) -> str | None:
    """Return the picture of an object, or None if no function is registered for its type.

    For None, a notebook shows the object as text.
    """
    draw = VIEWS.get(type(shown))
    return None if draw is None else draw(shown)
