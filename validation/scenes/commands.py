"""Commands for readers to copy: each repeats or explains a result of a report.

A user's scene has no name that `ghostball` knows. The command gives its file, and assumes that the
file is in the working directory.
"""

from __future__ import annotations

import shlex

from ghostball.reference_adapters.registry import OURS
from ghostball.validation.scenes.library import scene_names


def scene_argument(scene: str) -> str:
    """Return the argument for a scene on the command line: a shipped scene's name, or a file."""
    return shlex.quote(scene if scene in scene_names() else f"./{scene}.toml")


def simulate(scene: str, engine: str | None = None, *, recorded: bool = False) -> str:
    """Return the command that runs one scene on one engine (default: Ghostball's).

    `engine`: label of the engine, with its settings.
    `recorded`: whether the command prints the whole result, including the hash.
    """
    record = " --record events --format json" if recorded else ""
    return f"ghostball run {scene_argument(scene)}{_engine(engine)}{record}"


def explain(scene: str, engine: str) -> str:
    """Return the command that shows the first difference from the reference, and its cause."""
    return f"ghostball explain {scene_argument(scene)}{_engine(engine)}"


def validate(scene: str, engine: str, out: str) -> str:
    """Return the command that judges one scene on one engine again, with separate results."""
    return f"ghostball validate {scene_argument(scene)}{_engine(engine)} --out {shlex.quote(out)}"


def regress(scene: str | None = None, engine: str | None = None) -> str:
    """Return the command that compares an engine with its baselines.

    `scene`: None compares all scenes, including those without a file.
    `engine`: label of the engine, with its settings (default: Ghostball's).
    """
    chosen = "" if scene is None else f" {scene_argument(scene)}"
    return f"ghostball regress{chosen}{_engine(None if engine == OURS else engine)}"


def _engine(engine: str | None) -> str:
    return "" if engine is None else f" --engine {shlex.quote(engine)}"
