"""The shipped scenes: which there are, and how a name, a tag or a path finds one."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Literal

from ghostball.engine import Scene, SceneError

Suite = Literal["smoke", "full"]

FOLDER = Path(str(files("ghostball.validation.scenes")))
"""Where the shipped scenes lie; beside each, `NAME.expect.toml` holds its pass criteria."""

_CRITERIA_SUFFIX = ".expect.toml"


def shipped_scenes() -> tuple[Path, ...]:
    """Return the files of the shipped scenes, in order of name."""
    return tuple(
        sorted(
            (path for path in FOLDER.glob("*.toml") if not path.name.endswith(_CRITERIA_SUFFIX)),
            key=lambda path: path.stem,
        )
    )


def scene_names() -> tuple[str, ...]:
    """Return the names of the shipped scenes, in order."""
    return tuple(path.stem for path in shipped_scenes())


def find_scene(name_or_path: str | Path) -> Scene:
    """Return the shipped scene of that name, or read the scene file at that path.

    A name wins over a file of the same name in the working directory; write `./NAME` for the file.

    Raises
    ------
    SceneError
        Where there is neither, naming the nearest shipped scenes; or where the file is refused.
    """
    text = str(name_or_path)
    if text in scene_names():
        return _shipped(text)
    path = Path(name_or_path)
    if path.exists() or path.suffix == ".toml" or len(path.parts) > 1:
        return Scene.load(path)
    raise SceneError(_unknown("scene", text, scene_names()))


def select(names_or_tags: Sequence[str] = (), suite: Suite = "full") -> list[Scene]:
    """Return the scenes that a run is about, each once.

    Parameters
    ----------
    names_or_tags : sequence of str
        Names of shipped scenes, tags, or paths, in the order wanted; empty is the whole suite.
    suite : "smoke" or "full"
        Without names: the scenes tagged "smoke", or all of them.

    Raises
    ------
    SceneError
        Where one of them is neither a name, nor a tag, nor a path.
    """
    shipped = [_shipped(name) for name in scene_names()]
    if not names_or_tags:
        return [scene for scene in shipped if suite == "full" or suite in scene.tags]
    tags, paths = scene_tags(), paths_among(names_or_tags)
    chosen: dict[str, Scene] = {}
    for wanted in names_or_tags:
        if wanted in scene_names() or wanted in paths:
            found = [find_scene(wanted)]
        elif wanted in tags:
            found = [scene for scene in shipped if wanted in scene.tags]
        else:
            raise SceneError(_unknown("scene or tag", wanted, (*scene_names(), *tags)))
        for scene in found:
            if chosen.setdefault(scene.name, scene) != scene:
                raise SceneError(
                    f"`name` must differ between the scenes of a run, but two different ones are "
                    f'called "{scene.name}" (the second came from "{wanted}"). Rename one'
                )
    return list(chosen.values())


def scene_tags() -> tuple[str, ...]:
    """Return the tags of the shipped scenes, in order."""
    return tuple(sorted({tag for name in scene_names() for tag in _shipped(name).tags}))


def paths_among(names_or_tags: Sequence[str]) -> tuple[str, ...]:
    """Return those that are files, in order; a name or a tag wins over a file called like it."""
    known = {*scene_names(), *scene_tags()}
    return tuple(
        wanted
        for wanted in names_or_tags
        if wanted not in known and (Path(wanted).suffix == ".toml" or Path(wanted).exists())
    )


@cache
def _shipped(name: str) -> Scene:
    return Scene.load(FOLDER / f"{name}.toml")


def _unknown(what: str, text: str, known: Sequence[str]) -> str:
    close = get_close_matches(text, known, n=3)
    hint = f"Did you mean {' or '.join(close)}?" if close else f"Known: {', '.join(known)}"
    return f'unknown {what} "{text}": not shipped, and no file of that name. {hint}'
