"""What `[tool.ghostball]` of a project's `pyproject.toml` says: engines, scenes, folders.

    [tool.ghostball]
    engines = ["my_engine:simulate"]        # default: as each command says
    scenes = ["smoke", "scenes/*.toml"]     # default: all that are shipped
    baselines = "baselines"
    fail_on = "changed"                     # or "worse", or "limits": what fails the gate
    out = "out"

Commands take from it what they aren't given, and so does the pytest plugin. Paths are relative to
the file, which is the nearest one upwards that has such a table.
"""

from __future__ import annotations

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

Text = Annotated[str, Field(pattern=r"\S", strict=True)]


class ConfigError(GhostballError, ValueError):
    """A configuration that can't be read, or says what nobody understands."""


class Config(BaseModel, frozen=True, extra="forbid"):
    """The settings of a project.

    `engines`, `scenes`: as on the command line; empty where nothing is said.
    `baselines`, `out`: folders of the accepted baselines and of results.
    `fail_on`: what fails a comparison with baselines.
    """

    engines: tuple[Text, ...] = ()
    scenes: tuple[Text, ...] = ()
    baselines: Path = Path("baselines")
    fail_on: FailOn = "changed"
    out: Path = Path("out")

    def below(self, root: Path) -> Config:
        """Return the same with its paths relative to the working directory."""
        if root == Path.cwd():
            return self
        scenes = (
            str(root / one) if one.endswith(".toml") or "/" in one else one for one in self.scenes
        )
        paths = {"baselines": root / self.baselines, "out": root / self.out}
        return self.model_copy(update={"scenes": tuple(scenes), **paths})


def named_engines(given: Sequence[str] | None, config: Config) -> tuple[str, ...]:
    """Return the engines that the command line names, else the project's, each checked.

    Raises `EngineError` where one isn't here: who names an engine wants its verdict.
    """
    labels = tuple(given or config.engines)
    for label in labels:
        make_engine(label)
    return labels


def load_config(start: Path | None = None) -> Config:
    """Return the configuration of the project that a folder is in, the working directory's."""
    here = (start or Path.cwd()).resolve()
    for folder in (here, *here.parents):
        table = load_table(folder / FILE)
        if table is not None:
            return _checked(table, folder / FILE).below(folder)
    return Config()


def load_table(path: Path) -> Any:
    """Return the table of a file, or None where there is none."""
    try:
        text = read_text(path)
    except (FileNotFoundError, NotADirectoryError, PermissionError):
        return None
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: can't be read: {error}") from None
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
