"""Options and help of `report`, `scenes`, `engines` and `init`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from ghostball.cli.options import (
    AUTO,
    FigureChoice,
    Figures,
    Format,
    Jobs,
    TextOrJson,
    TextOrJsonOption,
    complete_engine,
    complete_scene,
    engine_option,
    format_option,
    out_option,
    plot_option,
    scene_argument,
)
from ghostball.cli.shared.calls import command

app = typer.Typer()


@command(app, "show.report")
@dataclass(frozen=True)
class ReportOptions:
    """Write the report of a run, or print or export its results.

    If the folder contains results of `stress`, the report has a section about them. In Python,
    `Results.open(DIR).to_frame()` gives the exported tables as data frames.
    """

    context: typer.Context
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="DIR", help="A folder that `validate`, `regress` or `stress` wrote."
        ),
    ]
    jobs: Jobs = AUTO
    figures: Figures = FigureChoice.NONE
    opened: Annotated[bool, typer.Option("--open", help="Open the report in a browser.")] = False
    form: Annotated[
        Format | None,
        format_option("Print the results in this format instead, as `validate` and `regress` do."),
    ] = None
    export: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER",
            help="Write the results into this folder instead, as JSON lines and as CSV: both "
            "formats for each table, such as cases, checks, metrics and events.",
        ),
    ] = None


@command(app, "show.scenes")
@dataclass(frozen=True)
class ScenesOptions:
    """List the shipped scenes or the metrics; show the file of a scene."""

    context: typer.Context
    wanted: Annotated[
        list[str] | None,
        scene_argument(
            "NAME|TAG",
            "Scenes to list: names, tags or files, as for `validate` (default: all shipped "
            "scenes). A single scene is printed as TOML.",
        ),
    ] = None
    schema: Annotated[
        bool, typer.Option("--schema", help="Print the JSON schema of scene files instead.")
    ] = False
    export: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Write the scenes to DIR as JSON, for engines in any language."
        ),
    ] = None
    pooltool: Annotated[
        bool,
        typer.Option("--pooltool", help="For --export: write files that pooltool loads."),
    ] = False
    golden: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Write golden shots to DIR, for engines in any language: about 200 scenes with "
            "their exact results as JSON, and a README. DIR must be new or empty. Takes a minute.",
        ),
    ] = None
    metrics: Annotated[
        bool,
        typer.Option(
            "--metrics", help="List the metrics instead: limits and --metric use their names."
        ),
    ] = False
    form: TextOrJsonOption = TextOrJson.TEXT


@command(app, "show.engines")
@dataclass(frozen=True)
class EnginesOptions:
    """List engines, describe them, or measure which time step each needs.

    A description lists an engine's settings, and how it supports each feature of scenes.

    With --steps, an engine whose settings have a time step, `dt`, simulates each scene with time
    steps from 20 ms down, each half as long as the one before. The error is the largest distance of
    a ball from its reference rest position. Runs are made one after another in this process, so
    that run times are accurate; the default engines take some minutes. Exit status 4 if no engine
    supports any of the scenes.
    """

    context: typer.Context
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="ENGINE",
            help="Engines to describe in full (default: one line for each engine).",
            autocompletion=complete_engine,
        ),
    ] = None
    recipe: Annotated[
        bool,
        typer.Option(
            "--recipe",
            help="Print the best known settings of the engine as a program that needs only this "
            "engine; its comments explain the effect of each setting.",
        ),
    ] = False
    check: Annotated[
        bool,
        typer.Option(
            "--check",
            help="Check the whole installation instead: Python, packages, compiled kernels, "
            "engines and scenes. Exit status 1 if something is broken.",
        ),
    ] = False
    steps: Annotated[
        bool,
        typer.Option(
            "--steps",
            help="Measure each engine's error against its run time instead, and recommend a time "
            "step. Engines may have settings, such as pymunk:iterations=1, or be your own, such as "
            "my_module:simulate. Default: those of [tool.ghostball] in pyproject.toml, else "
            "ghostball, pymunk in four configurations and pybullet in three, the paper's two "
            "algorithms, and the certified results.",
        ),
    ] = False
    scene: Annotated[
        list[str] | None,
        typer.Option(
            "--scene",
            metavar="SCENE|TAG",
            help="For --steps: a scene with a closed form, or one certified to the end; "
            "repeatable (default: six scenes with a closed form).",
            autocompletion=complete_scene,
        ),
    ] = None
    repeats: Annotated[
        int,
        typer.Option(
            min=1,
            help="For --steps: number of rounds, each with a different phase of the time step; the "
            "shortest run time counts. Slow shots have two rounds.",
        ),
    ] = 4
    out: Annotated[
        Path | None, out_option("For --steps: write the measurements to DIR, as precision.json.")
    ] = None
    plot: Annotated[
        Path | None,
        plot_option(
            "For --steps: draw the error against the steps per simulated second, with the "
            "recommended step ringed"
        ),
    ] = None
    form: Annotated[TextOrJson, format_option("For --steps: what is printed on stdout.")] = (
        TextOrJson.TEXT
    )


@command(app, "show.init")
@dataclass(frozen=True)
class InitOptions:
    """Start a project: write its settings and an example engine.

    The settings are [tool.ghostball] in pyproject.toml. Then `ghostball regress` and `ghostball
    accept --reason "..."` store the first baselines.
    """

    engine: Annotated[
        str | None,
        engine_option(
            "Your engine, such as my_engine:simulate (default: write an example engine)."
        ),
    ] = None
    ci: Annotated[
        bool,
        typer.Option(
            "--ci",
            help="Also write a GitHub Actions workflow that runs `regress`; in a project that "
            "already has settings, write only the workflow.",
        ),
    ] = False
