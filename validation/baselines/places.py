"""Where baselines lie: a folder for each engine, a file for each scene."""

from __future__ import annotations

import re
from pathlib import Path

from ghostball.model import GhostballError
from ghostball.reference_adapters.registry import engine_name, parse_spec, spec_of

ENDING = ".json"


class BaselineError(GhostballError, ValueError):
    """A baseline that can't be read, or is nonsense: edited by hand, or cut short."""


def engine_key(label: str) -> str:
    """Return what baselines call an engine: its own name, with the settings that it was given.

    So `games.my_engine:simulate:dt=1e-3` is `my_engine:dt=1e-3`, wherever that module may move.
    """
    return spec_of(engine_name(label), parse_spec(label)[1])


def engine_folder(baselines: Path, engine: str) -> Path:
    """Return where the baselines of one engine lie, in the folder of those of all.

    Raises `BaselineError` where that is no folder.
    """
    folder = baselines / re.sub(r"[^\w.,=+-]+", "_", engine)
    for place in (baselines, folder):
        if place.exists() and not place.is_dir():
            raise BaselineError(f"{place}: not a folder. Choose another `--baselines`")
    return folder


def baseline_path(folder: Path, scene: str) -> Path:
    """Return the file of a scene's baseline."""
    return folder / f"{scene}{ENDING}"


def baseline_names(folder: Path) -> tuple[str, ...]:
    """Return the scenes that have a baseline in a folder, in order; none where it isn't there."""
    return tuple(sorted(path.name.removesuffix(ENDING) for path in folder.glob(f"*{ENDING}")))
