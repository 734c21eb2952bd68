"""What `ghostball init` and `ghostball new` do: write the files that a project begins with."""

from __future__ import annotations

import importlib.util
import json
import re
from collections.abc import Mapping
from pathlib import Path

import typer

from ghostball._config import FILE, ConfigError, load_table
from ghostball._terminal import say
from ghostball.engine import Ball, GhostballError, Scene, Table
from ghostball.engine.scene.toml import dumps
from ghostball.reference_adapters import make_engine
from ghostball.validation.results.files import write_all_whole

_CONFIG = """\
[tool.ghostball]
engines = [{engine}]  # what `ghostball validate`, `regress` and pytest run
scenes = ["smoke"]  # names, tags, files such as "scenes/*.toml"; "full" is all that are shipped
baselines = "baselines"  # what was accepted: to be committed
out = "out"  # results: not to be committed
"""

_ABOUT = '''\
"""An engine for `ghostball validate` and `ghostball regress`: put your own in its place.

It sees contacts up to a step late, and says so by its `resolution`: its shots are held to what a
step of that size allows.
"""

'''


class ExistsError(GhostballError, FileExistsError):
    """A file that would be overwritten."""


def init(engine: str | None) -> None:
    """Write `[tool.ghostball]`, and, unless one is named, an engine to begin from.

    Raises
    ------
    GhostballError
        Where there is one already, or the engine isn't there. Nothing is written then.
    """
    path = Path(FILE)
    if load_table(path) is not None:
        raise ConfigError(f"{path}: has `[tool.ghostball]` already. Edit it there")
    files: dict[Path, str] = {}
    if engine is None:
        engine = "my_engine:MyEngine"
        files |= _engine_file("my_engine")
    else:
        make_engine(engine)
    before = path.read_text(encoding="utf-8").rstrip("\n") + "\n\n" if path.exists() else ""
    files[path] = before + _CONFIG.format(engine=json.dumps(engine))
    _write(files)
    say(
        "Next: `ghostball validate` runs it and says how right it is; `ghostball regress` and "
        '`ghostball accept --reason "..."` keep what it did'
    )


def new_engine(name: str) -> None:
    """Write NAME.py with an engine to begin from.

    Raises
    ------
    GhostballError
    """
    files = _engine_file(name)
    _write(files)
    say(f"Next: `ghostball validate smoke -e {name}:{_class_name(name)}`")


def new_scene(name: str) -> None:
    """Write NAME.toml, a scene to begin from, and its limits beside it.

    Raises
    ------
    GhostballError
    """
    if not re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", name):
        raise GhostballError(
            f"a scene's name must be lower-case words with hyphens between, got {name!r}, such as "
            "my-shot"
        )
    scene = Scene(
        name=name,
        title="A ball cuts another",
        table=Table(length=2.54, width=1.27),
        balls=[
            Ball(id="cue", position=(0.6, 0.60), velocity=(1.0, 0.0)),
            Ball(id="object", position=(1.2, 0.63)),
        ],
    )
    limits = """\
[[criteria]]
engines = ["pymunk"]
metric = "rest_error_max"  # `ghostball metrics` lists them
at_most = 5e-3
reason = "why no more than 5 mm"
"""
    _write({Path(f"{name}.toml"): dumps(scene), Path(f"{name}.expect.toml"): limits})
    say(f"Next: `ghostball run {name}.toml --plot {name}.png`, `ghostball validate {name}.toml`")


def _engine_file(name: str) -> dict[Path, str]:
    """Return the file of an engine: the example that comes with ghostball, under this name."""
    if not name.isidentifier():
        raise GhostballError(
            f"an engine's name must be that of a Python module, got {name!r}, such as my_engine"
        )
    spec = importlib.util.find_spec("ghostball.validation.examples.stepper")
    assert spec is not None
    assert spec.origin is not None
    text = Path(spec.origin).read_text(encoding="utf-8")
    code = text.partition('"""\n\n')[2]
    own = code.replace("Stepper", _class_name(name)).replace(
        '"stepper"', json.dumps(name.replace("_", "-"))
    )
    return {Path(f"{name}.py"): _ABOUT + own}


def _class_name(name: str) -> str:
    return "".join(word.capitalize() for word in name.split("_"))


def _write(files: Mapping[Path, str]) -> None:
    there = [path for path in files if path.exists() and path.name != FILE]
    if there:
        raise ExistsError(f"{there[0]}: is there already. Choose another name, or remove it")
    try:
        write_all_whole(files)
    except OSError as error:
        raise GhostballError(
            f"{error.filename}: can't be written: {error.strerror or type(error).__name__}"
        ) from None
    for path in files:
        typer.echo(path)
