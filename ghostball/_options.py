"""Options that several commands share, and the values that they take."""

from __future__ import annotations

import enum
from pathlib import Path
from typing import Annotated

import typer

from ghostball._terminal import check_writable


class RecordChoice(enum.StrEnum):
    """What a run keeps; see `engine.Record`."""

    REST = "rest"
    EVENTS = "events"
    TRAJECTORY = "trajectory"


class SuiteChoice(enum.StrEnum):
    """Which of the shipped scenes run."""

    SMOKE = "smoke"
    FULL = "full"


class StressSuite(enum.StrEnum):
    """How much `stress` tries."""

    QUICK = "quick"
    FULL = "full"


SceneName = Annotated[
    str,
    typer.Argument(
        metavar="SCENE",
        help="A shipped scene's name (`ghostball scenes` lists them), or a TOML file.",
    ),
]

EngineSpec = Annotated[
    str,
    typer.Option(
        metavar="NAME[:KEY=VALUE,...]",
        help="Engine and its settings, as `ghostball engines` lists them, such as pymunk:dt=1e-4.",
    ),
]

BaselineFolder = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR",
        help="Folder of the baselines (default: validation/baselines/accepted, as shipped).",
    ),
]

Figures = Annotated[
    bool,
    typer.Option(
        "--figures",
        help="Draw also four figures of each scene, as PNG and SVG: about a second a scene. "
        "report.html needs none. Without this option, those of an earlier report are removed.",
    ),
]

ShotLimit = Annotated[
    float,
    typer.Option(
        metavar="SECONDS",
        help="How long an engine other than ours may take for a shot. It runs in a process of its "
        "own: after that it is ended, and has failed.",
    ),
]

ClusterAddress = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help="The scheduler of a Dask cluster, such as tcp://10.0.0.1:8786, whose workers do it "
        "instead, each task in a process of its own; they need this very ghostball. --jobs is "
        "then of what stays here. Needs: pip install 'ghostball[cluster]'.",
    ),
]

AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object instead of tables.")]


def jobs_option(what: str) -> typer.models.OptionInfo:
    """Return the option `--jobs`; `what` these processes do."""
    option: typer.models.OptionInfo = typer.Option(min=1, help=f"Processes that {what}.")
    return option


def plot_option(what: str) -> typer.models.OptionInfo:
    """Return the option `--plot`, which `check_plot` looks at; `what` it draws."""
    option: typer.models.OptionInfo = typer.Option(
        metavar="FILE", help=f"{what} (.png, .svg or .pdf)."
    )
    return option


def engines_option(default: str) -> typer.models.OptionInfo:
    """Return the option `--engines`; `default` says which they are where it is left out."""
    option: typer.models.OptionInfo = typer.Option(
        metavar="A,B,...",
        help="Engines, with settings as for `simulate --engine`, such as "
        f"ghostball,pymunk:mode=landed (default: all that are shipped, {default}).",
    )
    return option


def check_plot(path: Path) -> None:
    """Refuse a picture that can't be made, before the run.

    Raises
    ------
    GhostballError
        Where it can't be written.
    """
    from ghostball.reports.plot import ENDINGS  # noqa: PLC0415

    if path.suffix.lower() not in ENDINGS:
        raise typer.BadParameter(
            f"must end in {', '.join(ENDINGS)}, got {path.name!r}", param_hint="--plot"
        )
    check_writable(path, "--plot")
