"""The scripts and the style sheet of the replay, as text to put into a page."""

from __future__ import annotations

from importlib.resources import files
from typing import Final

REPLAY_SCRIPTS: Final = (
    "replay_parts.js",
    "replay_look.js",
    "replay_cloth.js",
    "replay_player.js",
    "replay_turning.js",
    "replay_motion.js",
    "replay_plate.js",
    "replay_side.js",
    "replay_timeline.js",
    "replay_readout.js",
    "replay_events.js",
    "replay_help.js",
    "replay.js",
    "compare.js",
)
"""In the order in which a page runs them: each adds to the global object `Ghostball`."""

REPLAY_STYLES: Final = ("replay.css",)


def replay_script() -> str:
    """Return what defines `Ghostball.mountReplay` and `Ghostball.mountCompare`, for `<script>`."""
    return "\n".join(_asset(name) for name in REPLAY_SCRIPTS)


def replay_style() -> str:
    """Return the style sheet of both, for `<style>`."""
    return "\n".join(_asset(name) for name in REPLAY_STYLES)


def _asset(name: str) -> str:
    return (files(__package__) / "assets" / name).read_text(encoding="utf-8")
