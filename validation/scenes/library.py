"""The shipped scenes, and finding scenes by name, tag or path."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
from fnmatch import fnmatchcase
from functools import cache
from glob import glob
from pathlib import Path

from ghostball.model import Scene, SceneError
from ghostball.reference_adapters.pooltool_files import load_pooltool

FOLDER = Path(__file__).parent
"""Folder of the shipped scenes; beside each scene, `NAME.expect.toml` holds its criteria."""

CRITERIA_SUFFIX = ".expect.toml"
"""Ending of a criteria file's name: `break-16.toml` has its criteria in `break-16.expect.toml`."""

FULL = "full"
"""Argument in place of names and tags that selects all shipped scenes except those of the board."""

BOARD = "board"
"""Tag of the scenes that show how engines differ, and name of their folder in `FOLDER`."""


@cache  # a run calls it hundreds of times
def shipped_scenes() -> tuple[Path, ...]:
    """Return the files of the shipped scenes, sorted by name; those of the board come last."""
    return (*_scenes_in(FOLDER), *_scenes_in(FOLDER / BOARD))


def _scenes_in(folder: Path) -> list[Path]:
    paths = (path for path in folder.glob("*.toml") if not path.name.endswith(CRITERIA_SUFFIX))
    return sorted(paths, key=lambda path: path.stem)


@cache
def _by_name() -> dict[str, Path]:
    return {path.stem: path for path in shipped_scenes()}


def scene_names() -> tuple[str, ...]:
    """Return the names of the shipped scenes, in the order of `shipped_scenes`."""
    return tuple(_by_name())


def scene_path(name: str) -> Path:
    """Return the file of a shipped scene."""
    return _by_name()[name]


def find_scene(name_or_path: str | Path) -> Scene:
    """Return the shipped scene with a name, or read the scene file at a path.

    A file whose name ends in .json is read as a shot of pooltool.

    A name has priority over a file with the same name in the working directory; use `./NAME` for
    the file.

    Raises
    ------
    GhostballError
        If there is neither (the message names similar shipped scenes), or if the file is invalid.
    """
    text = str(name_or_path)
    if text in scene_names():
        return _shipped(text)
    path = Path(name_or_path)
    if path.suffix == ".json":
        return load_pooltool(path)
    if path.exists() or path.suffix == ".toml" or len(path.parts) > 1:
        return Scene.load(path)
    raise SceneError(_unknown("scene", text, scene_names()))


def select(wanted: Sequence[str] = ()) -> list[Scene]:
    """Return the selected scenes, each once.

    `wanted`: names of shipped scenes, tags, paths, or patterns of names and paths, such as
        "break-*" and "mine/*.toml". The scenes keep this order. "full", or nothing, selects all
        shipped scenes except those of the board.

    Raises `SceneError` if an argument is neither a name, nor a tag, nor a path, nor a matching
    pattern.
    """
    shipped = [_shipped(name) for name in scene_names()]
    tags = scene_tags()
    chosen: dict[str, Scene] = {}
    for one in expand(wanted or [FULL]):
        if one == FULL:
            found = [scene for scene in shipped if BOARD not in scene.tags]
        elif one in scene_names() or paths_among([one]):
            found = [find_scene(one)]
        elif one in tags:
            found = [scene for scene in shipped if one in scene.tags]
        else:
            raise SceneError(_unknown("scene or tag", one, (*scene_names(), *tags)))
        for scene in found:
            if chosen.setdefault(scene.name, scene) != scene:
                raise SceneError(
                    f"`name` must differ between the scenes of a run, but two different ones are "
                    f'called "{scene.name}" (the second came from "{one}"). Rename one'
                )
    return list(chosen.values())


def expand(wanted: Sequence[str]) -> tuple[str, ...]:
    """Return names, tags and paths, with each pattern replaced by its matches.

    Raises `SceneError` if a pattern matches nothing.
    """
    found: dict[str, None] = {}
    for one in wanted:
        if not any(mark in one for mark in "*?[") or Path(one).exists():
            found[one] = None
            continue
        matches = [name for name in scene_names() if fnmatchcase(name, one)]
        files = (path for path in sorted(glob(one, recursive=True)) if path.endswith(".toml"))
        matches += [path for path in files if not path.endswith(CRITERIA_SUFFIX)]
        if not matches:
            raise SceneError(
                f'pattern "{one}" matches no shipped scene and no TOML file here. `ghostball '
                "scenes` lists the shipped scenes"
            )
        found |= dict.fromkeys(matches)
    return tuple(found)


def scene_tags() -> tuple[str, ...]:
    """Return the tags of the shipped scenes, sorted."""
    return tuple(sorted({tag for name in scene_names() for tag in _shipped(name).tags}))


def paths_among(wanted: Sequence[str]) -> tuple[str, ...]:
    """Return the arguments that are files, in order; a name or tag has priority over a file."""
    known = {FULL, *scene_names(), *scene_tags()}
    return tuple(
        one
        for one in expand(wanted)
        if one not in known and (Path(one).suffix == ".toml" or Path(one).exists())
    )


@cache
def _shipped(name: str) -> Scene:
    return Scene.load(scene_path(name))


def _unknown(what: str, text: str, known: Sequence[str]) -> str:
    close = get_close_matches(text.lower(), known, n=3)
    hint = f"Did you mean {' or '.join(close)}?" if close else "`ghostball scenes` lists them"
    return f'unknown {what} "{text}": neither a shipped scene nor a file. {hint}'
