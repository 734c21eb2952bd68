"""Engines that are optional: each is an extra of this package."""

from __future__ import annotations

import importlib.util


def why_not_installed(module: str, *, extra: str) -> str | None:
    """Return how to get an engine whose module isn't there, or None where it is.

    `module`: what the engine's package imports as.
    `extra`: which extra of this package installs it.
    """
    if importlib.util.find_spec(module) is not None:
        return None
    return (
        f"it is optional, and not installed. Run `python -m pip install 'ghostball[{extra}]'`, or "
        "`ghostball[engines]` for all optional engines"
    )
