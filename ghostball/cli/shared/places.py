"""Where in a project's files its engines are, and what its baselines say."""

from __future__ import annotations

import inspect
import os
import re
import sys
from operator import attrgetter
from pathlib import Path
from typing import Any

from ghostball.model.text_files import read_text
from ghostball.reference_adapters.base import EngineError
from ghostball.reference_adapters.registry import engine_class, parse_spec
from ghostball.reports.ci.findings import Place, Places, relative_to_root
from ghostball.validation.baselines.places import baseline_path, engine_folder

_FRAME = re.compile(r'^\s*File "(.+)", line (\d+)', re.MULTILINE)


def places_in(baselines: Path) -> Places:
    """Return what finds places in the project that the working directory is of.

    `baselines`: the folder of the baselines of all engines.
    """
    root = project_root()

    def engine(label: str, trace: str) -> Place | None:
        return _of_failure(trace, root) or _of_engine(label, root)

    def baseline(name: str, scene: str, says: str) -> Place | None:
        path = baseline_path(engine_folder(baselines, name), scene)
        file = relative_to_root(path, root)
        return None if file is None else Place(file, _line_of(path, says))

    return Places(engine, baseline)


def project_root() -> Path:
    """Return the folder that places are relative to: in a workflow of GitHub, its checkout."""
    return Path(os.environ.get("GITHUB_WORKSPACE") or Path.cwd()).resolve()


def _of_failure(trace: str, root: Path) -> Place | None:
    """Return the innermost line of a traceback that is the project's own."""
    for name, line in reversed(_FRAME.findall(trace)):
        file = relative_to_root(Path(name), root)
        if file is not None and "site-packages" not in file:
            return Place(file, int(line))
    return None


def _of_engine(label: str, root: Path) -> Place | None:
    """Return where an engine's class or function begins."""
    try:
        name = parse_spec(label)[0]
        found: Any = engine_class(name)
        module, _, attribute = name.partition(":")
        if attribute:  # as it stands there
            found = attrgetter(attribute)(sys.modules[module])
        source, (_, line) = inspect.getsourcefile(found), inspect.getsourcelines(found)
    except (EngineError, OSError, TypeError):  # not here, or in no file
        return None
    file = None if source is None else relative_to_root(Path(source), root)
    return None if file is None else Place(file, line)


def _line_of(path: Path, says: str) -> int:
    """Return the line of a baseline that says something; the first where none does."""
    try:
        lines = read_text(path).splitlines()
    except (OSError, UnicodeDecodeError):
        return 1
    return next((k for k, line in enumerate(lines, 1) if line.startswith(f'"{says}": ')), 1)
