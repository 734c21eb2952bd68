"""Options that several commands share, and their values."""

from __future__ import annotations

import enum
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer


class RecordChoice(enum.StrEnum):
    """What a run records; see `model.Record`."""

    REST = "rest"
    EVENTS = "events"
    TRAJECTORY = "trajectory"


class OriginChoice(enum.StrEnum):
    """Origin of the coordinates of tracks."""

    CORNER = "corner"
    CENTRE = "centre"


class Format(enum.StrEnum):
    """Formats of the results of a run on stdout."""

    TEXT = "text"
    JSON = "json"
    CSV = "csv"
    JUNIT = "junit"
    MARKDOWN = "markdown"
    GITHUB = "github"


class FailOnChoice(enum.StrEnum):
    """What fails a comparison with baselines; see `baselines.regression.FailOn`."""

    CHANGED = "changed"
    WORSE = "worse"
    LIMITS = "limits"


FAIL_ON_MEANINGS = {
    FailOnChoice.CHANGED: "every change, even a better result",
    FailOnChoice.WORSE: "only larger errors, wrong collisions, failed limits, unfinished shots, "
    "and results that differ from run to run",
    FailOnChoice.LIMITS: "only failed limits and unfinished shots; no baseline is needed",
}
"""The meaning of each choice, in the words of the help, of `action.yml` and of docs/ci.md."""


class TextOrJson(enum.StrEnum):
    """Formats on stdout of commands that give no verdicts."""

    TEXT = "text"
    JSON = "json"


class FigureChoice(enum.StrEnum):
    """Pictures of a report."""

    PNG = "png"
    SVG = "svg"
    NONE = "none"


def complete_scene(incomplete: str) -> list[str]:
    """Return the shipped scenes and tags with this prefix, for the shell's completion.

    The shell itself completes file names.
    """
    from ghostball.validation.scenes.library import (  # noqa: PLC0415
        scene_names,
        scene_tags,
    )

    return [one for one in (*scene_names(), *scene_tags()) if one.startswith(incomplete)]


def complete_engine(incomplete: str) -> list[str]:
    """Return the installed engines with this prefix, for the shell's completion."""
    from ghostball.reference_adapters import engine_names  # noqa: PLC0415

    return [one for one in engine_names() if one.startswith(incomplete)]


# typer's functions return Any. These helpers return the types that mypy needs in `Annotated`.


def scene_argument(metavar: str, text: str) -> typer.models.ArgumentInfo:
    """Return an argument that names scenes, with its help text."""
    option: typer.models.ArgumentInfo = typer.Argument(
        metavar=metavar, help=text, autocompletion=complete_scene
    )
    return option


def engine_option(text: str) -> typer.models.OptionInfo:
    """Return the option `--engine`, with its help text."""
    option: typer.models.OptionInfo = typer.Option(
        "--engine", "-e", metavar="ENGINE", help=text, autocompletion=complete_engine
    )
    return option


def engines_option(default: str) -> typer.models.OptionInfo:
    """Return the repeatable option `--engine`; `default` names its default in the help."""
    return engine_option(
        f"Engine; repeatable. {_ENGINE} Default: those of [tool.ghostball] in "
        f"pyproject.toml, else {default}."
    )


def out_option(text: str, metavar: str = "DIR") -> typer.models.OptionInfo:
    """Return the option `--out`, with its help text; the value is a folder by default."""
    option: typer.models.OptionInfo = typer.Option("--out", "-o", metavar=metavar, help=text)
    return option


def plot_option(text: str, endings: str = ".png, .svg or .pdf") -> typer.models.OptionInfo:
    """Return the option `--plot`, with its help text; `check_plot` checks the value."""
    option: typer.models.OptionInfo = typer.Option(metavar="FILE", help=f"{text} ({endings}).")
    return option


def format_option(text: str) -> typer.models.OptionInfo:
    """Return the option `--format`, with its help text."""
    option: typer.models.OptionInfo = typer.Option("--format", help=text)
    return option


_ENGINE = (
    "A name and settings, as `ghostball engines` lists them, such as pymunk:dt=1e-4; or a function "
    "or class in a module, such as my_module:simulate."
)

SceneName = Annotated[
    str,
    scene_argument(
        "SCENE",
        "Name of a shipped scene (`ghostball scenes` lists them), a TOML file, or a JSON file that "
        "pooltool saved.",
    ),
]

SceneNames = Annotated[
    list[str] | None,
    scene_argument(
        "SCENE|TAG",
        "Names or tags of shipped scenes (`ghostball scenes` lists both), TOML files, or "
        "patterns such as 'break-*'; smoke is a quick selection. Default: those of "
        "[tool.ghostball] in pyproject.toml, else all shipped scenes.",
    ),
]

EngineSpec = Annotated[str, engine_option(f"Engine. {_ENGINE}")]

GuardedEngines = Annotated[list[str] | None, engines_option("ghostball")]

BaselineFolder = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR",
        help="Folder of the baselines, with a subfolder for each engine (default: that of "
        "[tool.ghostball] in pyproject.toml, else baselines).",
    ),
]

TimeLimit = Annotated[
    float, typer.Option(metavar="SECONDS", help="Time limit for a scene on an engine.")
]

ShotLimit = Annotated[
    float,
    typer.Option(
        metavar="SECONDS",
        help="Time limit for a shot on an engine other than Ghostball's. The engine runs in its "
        "own process. At the limit, the process is ended, and the engine counts as not finished.",
    ),
]

ALL_RELATIONS = "all"
"""Value of `--relations` without names."""

RELATION_NAMES = (
    "rotate",
    "translate",
    "mirror",
    "renumber",
    "scale",
    "boost",
    "split",
    "far-ball",
)
"""The names in `validation.checks.relations.WORDS`, without importing it."""

Relations = Annotated[
    str | None,
    typer.Option(
        metavar="[NAME,...]",
        help="Also simulate related shots, and check that both runs agree: "
        f"{', '.join(RELATION_NAMES)}. Without names: every relation that the scene supports.",
    ),
]

Rerun = Annotated[
    bool, typer.Option("--rerun", help="Run everything again, even if it is unchanged.")
]

Figures = Annotated[
    FigureChoice,
    typer.Option(
        help="Pictures to write beside report.html, one sheet for each scene: PNG, PNG and SVG, or "
        "none."
    ),
]

ClusterAddress = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help="The scheduler of a Dask cluster, such as tcp://10.0.0.1:8786. Its workers run the "
        "tasks, each in its own process, and must have the same code. --jobs then limits only the "
        "tasks on this machine. Needs: pip install '.[cluster]' in a clone of Ghostball.",
    ),
]

ShardOption = Annotated[
    str | None,
    typer.Option(
        metavar="I/N",
        help="Run only part I of N of the shots, 1/N to N/N, and write its results to a Parquet "
        "file of its own. Several machines share the shots this way, without a cluster.",
    ),
]

FormatOption = Annotated[
    Format,
    format_option(
        "What is printed on stdout: tables, one JSON object, comparisons with the reference as "
        'CSV, JUnit XML, Markdown such as for "$GITHUB_STEP_SUMMARY", or annotations of a GitHub '
        "workflow run. With a format other than text, the tables go to stderr."
    ),
]

TextOrJsonOption = Annotated[TextOrJson, format_option("What is printed on stdout.")]


def processors(text: str | int) -> int:
    """Return the number of processes for a value of `--jobs`; "auto" is one for each processor.

    Raises `typer.BadParameter` if the value isn't "auto" or a number of at least 1.
    """
    if text == AUTO:
        return processor_count()
    try:
        jobs = int(text)
    except ValueError:
        jobs = 0
    if jobs < 1:
        raise typer.BadParameter(f"must be auto or a number of at least 1, got {text!r}")
    return jobs


def processor_count() -> int:
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


AUTO: Any = "auto"
"""Value of `--jobs` for one process for each processor."""

Jobs = Annotated[
    int,
    typer.Option(
        "--jobs",
        "-j",
        metavar="N|auto",
        parser=processors,
        help="Number of worker processes; auto is one for each processor. Run times are most "
        "accurate with one worker.",
    ),
]


@dataclass(frozen=True, kw_only=True)
class SuiteOptions:
    """Options of the commands that run cases and store the results in a folder."""

    jobs: Jobs = AUTO
    form: FormatOption = Format.TEXT
    rerun: Rerun = False
    time_limit: TimeLimit = 600.0


@dataclass(frozen=True, kw_only=True)
class ShotOptions:
    """Options of the commands that simulate shots without a results folder."""

    form: TextOrJsonOption = TextOrJson.TEXT
    time_limit: ShotLimit = 600.0
