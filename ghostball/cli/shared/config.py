"""Settings of a project, from the table `[tool.ghostball]` of its `pyproject.toml`.

    [tool.ghostball]
    engines = ["my_engine:simulate"]        # default: see the help of each command
    scenes = ["smoke", "scenes/*.toml"]     # default: all shipped scenes
    baselines = "baselines"
    fail_on = "changed"                     # or "worse", or "limits": what fails `regress`
    out = "out"

The commands and the pytest plugin use these settings for options that aren't given. The file is the
nearest `pyproject.toml` with such a table, in the working directory or above. Paths are relative to
the folder of the file.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, Field, ValidationError

from ghostball.model import GhostballError
from ghostball.model.text_files import read_text
from ghostball.reference_adapters import make_engine
from ghostball.validation.baselines.regression import FailOn
from ghostball.validation.results.files import describe_validation_error, toml_of

FILE = "pyproject.toml"

NonBlankText = Annotated[str, Field(pattern=r"\S", strict=True)]


class ConfigError(GhostballError, ValueError):
    """A configuration that can't be read, or is invalid."""


class Config(BaseModel, frozen=True, extra="forbid"):
    """The settings of a project.

    `engines`, `scenes`: as on the command line; empty if the file doesn't set them.
    `baselines`, `out`: folders of the accepted baselines and of results.
    `fail_on`: what fails a comparison with baselines.
    """

    engines: tuple[NonBlankText, ...] = ()
    scenes: tuple[NonBlankText, ...] = ()
    baselines: Path = Path("baselines")
    fail_on: FailOn = "changed"
    out: Path = Path("out")

    def resolved(self, root: Path) -> Config:
        """Return the settings with paths that are valid in the working directory.

        `root`: folder to which the paths are relative.
        """
        if root == Path.cwd():
            return self
        scenes = (
            str(root / one) if one.endswith(".toml") or "/" in one else one for one in self.scenes
        )
        paths = {"baselines": root / self.baselines, "out": root / self.out}
        return self.model_copy(update={"scenes": tuple(scenes), **paths})


def named_engines(given: Sequence[str] | None, config: Config) -> tuple[str, ...]:
    """Return the engines of the command line, else those of the project.

    Raises `EngineError` if an engine is unknown or unavailable: a named engine is never skipped.
    """
    labels = tuple(given or config.engines)
    for label in labels:
        make_engine(label)
    return labels


def load_config(start: Path | None = None) -> Config:
    """Return the settings of the project that contains a folder, by default the working directory.

    Raises `ConfigError` if they can't be read, or are invalid.
    """
    here = (start or Path.cwd()).resolve()
    for folder in (here, *here.parents):
        table = load_table(folder / FILE)
        if table is not None:
            return _checked(table, folder / FILE).resolved(folder)
    return Config()


def load_table(path: Path) -> Any:
    """Return the table `[tool.ghostball]` of a file; None if the file or its table doesn't exist.

    A file in a folder that this user may not enter counts as missing. Raises `ConfigError` if the
    file can't be read for another reason.
    """
    try:
        text = read_text(path)
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, UnicodeDecodeError) as error:
        if not os.access(path.parent, os.X_OK):
            # The user may not enter this folder, so the file belongs to another project.
            return None
        why = getattr(error, "strerror", None) or str(error)
        raise ConfigError(
            f"{path}: can't be read: {why}. Its `[tool.ghostball]` may hold settings: make the "
            "file readable"
        ) from None
    if "ghostball" not in text:
        return None
    try:
        tool = toml_of(text).get("tool", {})
    except ValueError as error:
        raise ConfigError(f"{path}: not valid TOML: {error}") from None
    if not isinstance(tool, dict):
        raise ConfigError(f"{path}: `tool` must be a table, got {tool!r}")
    return tool.get("ghostball")


def _checked(table: Any, path: Path) -> Config:
    try:
        return Config.model_validate(table)
    except ValidationError as error:
        said = describe_validation_error(
            error, list(Config.model_fields), within="tool.ghostball", noun="setting"
        )
        raise ConfigError(f"{path}: {said}") from None
