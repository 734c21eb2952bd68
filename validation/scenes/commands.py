"""Commands that a reader can copy: each does again, or explains, what a report speaks of.

A scene of a user's own is no name to `ghostball`: it needs its file, which is taken to lie where
the command is given.
"""

from __future__ import annotations

import shlex

from ghostball.reference_adapters.registry import OURS
from ghostball.validation.scenes.library import scene_names


def scene_argument(scene: str) -> str:
    """Return what stands for a scene on the command line: a shipped one's name, else a file's."""
    return shlex.quote(scene if scene in scene_names() else f"./{scene}.toml")


def simulate(scene: str, engine: str | None = None, *, recorded: bool = False) -> str:
    """Return the command that runs one scene on one engine (default: ours).

    `engine`: with its settings, as a label says it.
    `recorded`: whether it prints all that it found, the hash too.
    """
    record = " --record events --format json" if recorded else ""
    return f"ghostball run {scene_argument(scene)}{_engine(engine)}{record}"


def explain(scene: str, engine: str) -> str:
    """Return the command that says where an engine leaves the true shot, and why."""
    return f"ghostball explain {scene_argument(scene)}{_engine(engine)}"


def validate(scene: str, engine: str, out: str) -> str:
    """Return the command that judges one scene on one engine again, in a folder of its own."""
    return f"ghostball validate {scene_argument(scene)}{_engine(engine)} --out {shlex.quote(out)}"


def regress(scene: str | None = None, engine: str | None = None) -> str:
    """Return the command that compares an engine with its baselines.

    `scene`: None compares all: also what is made by a rule and has no file.
    `engine`: with its settings, as a label says it (default: ours).
    """
    chosen = "" if scene is None else f" {scene_argument(scene)}"
    return f"ghostball regress{chosen}{_engine(None if engine == OURS else engine)}"


def _engine(engine: str | None) -> str:
    return "" if engine is None else f" --engine {shlex.quote(engine)}"
