"""`ghostball init`: write the first files of a project, or a GitHub workflow."""

from __future__ import annotations

import importlib.util
import json
import re
from collections.abc import Mapping
from importlib.metadata import metadata
from pathlib import Path

import typer

from ghostball.cli.shared.config import FILE, ConfigError, load_table
from ghostball.cli.shared.terminal import say
from ghostball.cli.show.commands import InitOptions
from ghostball.model import GhostballError
from ghostball.model.text_files import read_text
from ghostball.reference_adapters import make_engine
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.results.files import write_files

_CONFIG = """\
[tool.ghostball]
engines = [{engine}]  # what `ghostball validate`, `regress` and pytest run
scenes = ["smoke"]  # names, tags, files such as "scenes/*.toml"; "full" is all shipped scenes
baselines = "baselines"  # accepted results: commit this folder
out = "out"  # results: do not commit
"""

EXAMPLE = Path("my_engine.py")
"""The example engine that is written if no engine is named."""

WORKFLOW = Path(".github/workflows/ghostball.yml")

UNKNOWN_REPOSITORY = "OWNER/ghostball"
"""Placeholder for Ghostball's repository on GitHub if the installation doesn't name it."""


class ExistsError(GhostballError, FileExistsError):
    """A file that would be overwritten."""


def run(asked: InitOptions) -> ExitStatus:
    """Write `[tool.ghostball]`, and an example engine if no engine is named.

    With `--ci`, write a workflow, too, or only the workflow if the project has settings.

    Raises `ConfigError` if the project has settings, and an engine is named or no workflow is asked
    for; `ExistsError` if a file exists.
    """
    engine, ci = asked.engine, asked.ci
    path = Path(FILE)
    begun = load_table(path) is not None
    if begun and (not ci or engine is not None):
        raise ConfigError(f"{path}: already has `[tool.ghostball]`. Edit that table")
    files: dict[Path, str] = {} if begun else _project(engine)
    if ci:
        files[WORKFLOW] = workflow_text(package=_is_package(path))
    _write(files)
    if EXAMPLE in files:
        say(
            f"Next: `ghostball validate`. It fails in one scene, because {EXAMPLE} contains a "
            "deliberate mistake, and prints the command that names the mistake. Later, `ghostball "
            'regress` and `ghostball accept --reason "..."` detect changes'
        )
    elif not begun:
        say(
            "Next: `ghostball validate` measures the errors of your engine, and names the command "
            "that finds their cause. Later, `ghostball regress` and `ghostball accept --reason "
            '"..."` detect changes'
        )
    if ci:
        say(f"{WORKFLOW} compares each push with the baselines of `ghostball accept`: commit both")
        where = ""
        if UNKNOWN_REPOSITORY in files[WORKFLOW]:
            where = "OWNER by the GitHub account that hosts Ghostball, and "
        say(
            f"First edit the file: replace {where}COMMIT by the full hash of a commit of "
            "Ghostball, because there is no release yet"
        )
    return ExitStatus.PASSED


def _is_package(path: Path) -> bool:
    """Return whether pip can install the project, by its table `[project]`."""
    try:
        return path.exists() and "[project]" in read_text(path)
    except UnicodeDecodeError:
        return False


def _project(engine: str | None) -> dict[Path, str]:
    """Return the first files of a project, by path; raises `EngineError` for an invalid engine."""
    path = Path(FILE)
    files: dict[Path, str] = {}
    if engine is None:
        engine = f"{EXAMPLE.stem}:simulate"
        files[EXAMPLE] = _engine_text()
    else:
        make_engine(engine)
    before = read_text(path).rstrip("\n") + "\n\n" if path.exists() else ""
    files[path] = before + _CONFIG.format(engine=json.dumps(engine))
    return files


def _engine_text() -> str:
    """Return the source of the example engine that comes with Ghostball."""
    spec = importlib.util.find_spec("ghostball.validation.examples.first_engine")
    assert spec is not None
    assert spec.origin is not None
    return Path(spec.origin).read_text(encoding="utf-8")


def _write(files: Mapping[Path, str]) -> None:
    there = [path for path in files if path.exists() and path.name != FILE]
    if there:
        raise ExistsError(f"{there[0]}: already exists. Choose another name, or remove it")
    write_files(files, "Choose another folder")
    for path in files:
        typer.echo(path)


def repository() -> str:
    """Return Ghostball's repository on GitHub, "account/name", from its installed metadata."""
    for one in metadata("ghostball").get_all("Project-URL") or ():
        if found := re.search(r"github\.com/([\w.-]+/[\w.-]+?)(?:\.git)?/?$", one):
            return found[1]
    return UNKNOWN_REPOSITORY


def workflow_text(*, package: bool) -> str:
    """Return the text of the workflow; `package`: whether pip can install the project."""
    text = Path(__file__).with_name("workflow.yml").read_text(encoding="utf-8")
    install = "          install: . # with the dependencies of the engine\n"
    return text.replace(UNKNOWN_REPOSITORY, repository()) + install * package
