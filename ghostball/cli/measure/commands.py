"""The commands that play shots and say how right they are."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ghostball.cli.shared.options import (
    AUTO,
    ClusterAddress,
    EngineSpec,
    FigureChoice,
    Figures,
    Format,
    FormatOption,
    Jobs,
    Plain,
    PlainFormat,
    RecordChoice,
    Rerun,
    SceneName,
    SceneNames,
    ShotLimit,
    TimeLimit,
    complete_scene,
    engine_option,
    engines_option,
    out_option,
    plot_option,
)
from ghostball.cli.shared.terminal import runs

app = typer.Typer()


@app.command()
@runs("measure.run")
def run(
    scene: SceneName,
    engine: EngineSpec = "ghostball",
    record: Annotated[
        RecordChoice | None,
        typer.Option(
            metavar="|".join(RecordChoice),
            help="What to keep: where the balls end, also each event (--format json prints them), "
            "or also the whole motion (default: rest; with --plot: trajectory).",
        ),
    ] = None,
    plot: Annotated[
        Path | None, plot_option("Draw the paths of the balls; .gif and .mp4 are films of the shot")
    ] = None,
    form: PlainFormat = Plain.TEXT,
    expect_hash: Annotated[
        str | None,
        typer.Option(
            metavar="HASH",
            help="Fail unless events and rest positions have this hash, which `--record events` "
            "prints: a line of a workflow that must change wherever a bit of the shot does.",
        ),
    ] = None,
    time_limit: ShotLimit = 600.0,
) -> None:
    """Run one scene on one engine; print where the balls stop.

    Exit status 1 where the engine fails, crashes, hangs or doesn't come to the end of the shot, or
    where the shot has another hash than was expected.
    """


@app.command()
@runs("measure.validate")
def validate(
    scenes: SceneNames = None,
    engine: Annotated[
        list[str] | None,
        engines_option(
            "ghostball, pymunk and pybullet in three ways each, and the paper's two algorithms"
        ),
    ] = None,
    out: Annotated[
        Path | None,
        out_option(
            "out",
            "Folder of the results. What it holds is replaced, but for cases that are unchanged: "
            "those aren't run again",
        ),
    ] = None,
    jobs: Jobs = AUTO,
    form: FormatOption = Format.TEXT,
    metric: Annotated[
        list[str] | None,
        typer.Option(
            "--metric",
            metavar="GLOB",
            help="Metrics that are computed and judged, such as rest_error_max or 'energy_*'; give "
            "it once for each (default: all; `ghostball metrics` lists them). Limits on others are "
            "left out, and counted.",
        ),
    ] = None,
    rerun: Rerun = False,
    cluster: ClusterAddress = None,
    time_limit: TimeLimit = 600.0,
    report: Annotated[bool, typer.Option(help="Write report.html after the run.")] = True,
    figures: Figures = FigureChoice.NONE,
    ensemble: Annotated[
        int | None,
        typer.Option(
            metavar="K",
            help="Play each scene also from K varied starts on every engine, and say how much "
            "their ends vary, such as `validate chaos --ensemble 20`: for shots too chaotic to be "
            "compared one by one.",
        ),
    ] = None,
    ensemble_size: Annotated[
        str | None,
        typer.Option(
            metavar="SIZE",
            help="How far starts are varied at most: speed and direction (relative, rad), and x "
            "and y of each ball (m) (default: velocity=1e-3,position=1e-4).",
        ),
    ] = None,
    details: Annotated[
        bool,
        typer.Option(
            "--details",
            help="For each scene and engine, compare rest positions, collisions and energy with "
            "the reference.",
        ),
    ] = False,
) -> None:
    """Run scenes on several engines; say which are right.

    Exit status 1 where a limit is broken, or an engine fails, crashes, hangs or doesn't come to the
    end of a shot; 4 where no limit covers what was run, so that nothing was judged.
    """


@app.command()
@runs("measure.explain")
def explain(
    scene: Annotated[
        str | None,
        typer.Argument(
            metavar="SCENE",
            help="A shipped scene's name, or a TOML file (default: the worst of the last run).",
            autocompletion=complete_scene,
        ),
    ] = None,
    engine: Annotated[
        str | None,
        engine_option(
            "Engine, as for `run` (default: the first of [tool.ghostball] in pyproject.toml)."
        ),
    ] = None,
    plot: Annotated[
        Path | None,
        plot_option(
            "Draw both shots over each other at the instant at which they part, with the "
            "collisions marked"
        ),
    ] = None,
    attribute: Annotated[
        bool,
        typer.Option(
            help="Say also whether the difference comes from the engine's step or its model. Takes "
            "three more runs, the finest at a sixteenth of the step."
        ),
    ] = True,
    form: PlainFormat = Plain.TEXT,
    time_limit: ShotLimit = 600.0,
) -> None:
    """Say what is wrong with an engine's shot, since when, and where it leaves the true one.

    First comes what is wrong: a coefficient, such as a friction or a restitution, and by which
    factor; the step, where the difference goes away with a shorter one; or other physics. Then the
    first collision that the engine or the truth lacks, what the other has in its place, by how
    much, and the balls there. The truth is certified where it can be. Exit status 0, whether they
    part or not; 1 where the engine fails, crashes, hangs or doesn't come to the end of the shot.
    """


@app.command()
@runs("measure.fit")
def fit(
    tracks: Annotated[
        Path,
        typer.Argument(
            metavar="TRACKS.csv",
            help="Where balls were: a CSV file with the header shot,ball,t,x,y; seconds and "
            "metres, the origin in a corner of the playing surface. Lines that begin with # are "
            "comments.",
        ),
    ],
    table: Annotated[
        tuple[float, float],
        typer.Option(
            metavar="LENGTH WIDTH", help="The playing surface between the cushions, x and y [m]."
        ),
    ],
    radius: Annotated[float, typer.Option(metavar="R", help="Radius of the balls [m].")],
    fields: Annotated[
        str | None,
        typer.Option(
            metavar="A,B,...",
            help="Fields of the physics to fit (default: frictions of the cloth, restitutions, and "
            "the friction of cushions, as far as the tracks tell them).",
        ),
    ] = None,
    preset: Annotated[
        str, typer.Option(metavar="NAME", help="Preset that gives what isn't fitted.")
    ] = "pool",
    law: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Law of cushions, as physics calls it (default: the one that fits best, or the "
            "preset's where the tracks don't tell them apart).",
        ),
    ] = None,
    nose_height: Annotated[
        float | None,
        typer.Option(
            metavar="METRES",
            help="Measured height of the cushion's nose above the cloth. Without it, the preset's "
            "height is assumed, and the errors allow for the range in the rules of pool.",
        ),
    ] = None,
    engine: EngineSpec = "ghostball",
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            metavar="FILE",
            help="Write the [physics] of a scene as TOML, with the errors as comments.",
        ),
    ] = None,
    plot: Annotated[Path | None, plot_option("Draw what is left of each event")] = None,
    form: PlainFormat = Plain.TEXT,
    time_limit: ShotLimit = 600.0,
) -> None:
    """Fit the physics of a real table to tracks of its balls, event by event.

    The fit uses the clean events in the tracks: stretches of rolling, contacts with one cushion,
    hits of a ball at rest. The engine simulates each event, and the fitted values minimize the
    differences from all of them. Needs: pip install '.[fit]' in a clone of Ghostball. Exit status 2
    if there are too few events.
    """


@app.command()
@runs("measure.stress")
def stress(
    only: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="FAMILY|FAMILY/TRIAL",
            help="Families (`ghostball stress --list` names them) or single trials, also as "
            "patterns such as 'grazing/*-miss-*' (default: all).",
        ),
    ] = None,
    engine: Annotated[
        list[str] | None,
        engines_option(
            "ghostball, pymunk and pybullet in two ways each, and the paper's two algorithms"
        ),
    ] = None,
    full: Annotated[
        bool, typer.Option("--full", help="All trials, not only what a CI has time for.")
    ] = False,
    out: Annotated[
        Path | None,
        out_option(
            "out/stress-quick or out/stress-full",
            "Folder of what is found. A run continues where an earlier one by the same code ended",
        ),
    ] = None,
    jobs: Jobs = AUTO,
    form: PlainFormat = Plain.TEXT,
    rerun: Rerun = False,
    cluster: ClusterAddress = None,
    time_limit: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS",
            help="How long a trial may take (default: each has a limit of its own, a minute or "
            "more): after that it is ended, and has broken the engine.",
        ),
    ] = None,
    listed: Annotated[
        bool,
        typer.Option(
            "--list",
            help="List the families and what they ask, or the trials of those that are named, and "
            "try nothing.",
        ),
    ] = False,
) -> None:
    """Try to break engines; say what each survives.

    The worst case of each is kept as a scene, and the report's page has a section of the runs in
    its folder: `ghostball report out`. Exit status 1 where an engine breaks that
    `--engine` names, or ours where none is named; 4 where no engine can be asked any of it.
    """


@app.command()
@runs("measure.leaderboard")
def leaderboard(
    engine: Annotated[
        list[str] | None,
        engines_option("none but the rows that are shipped; it adds a row"),
    ] = None,
    only: Annotated[
        bool, typer.Option("--only", help="Have no other rows than those of --engine.")
    ] = False,
    column: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="Column; give it once for each (default: all but those of --reported).",
        ),
    ] = None,
    reported: Annotated[
        bool, typer.Option("--reported", help="Show the columns of faults that people reported.")
    ] = False,
    sort: Annotated[
        str | None, typer.Option(metavar="NAME", help="Sort the rows by a column.")
    ] = None,
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="DIR", help="Folder that keeps what is measured.")
    ] = Path("out/board"),
    jobs: Jobs = AUTO,
    rerun: Rerun = False,
    time_limit: TimeLimit = 120.0,
    plot: Annotated[Path | None, plot_option("Draw the board")] = None,
    form: PlainFormat = Plain.TEXT,
) -> None:
    """Put engines on one board: how right each is in what distinguishes engines, and how fast.

    Beside that, how like a real table each can be. Cells are cases of the suite: what earlier runs
    measured with the same code is reused, and exit statuses are those of `validate`, but that an
    engine counts as judged where one of its shots is, with any of the steps that a column gives it.
    An engine that crashes or hangs costs its own cells.
    """


@app.command()
@runs("measure.precision")
def precision(
    scenes: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="SCENE|TAG",
            help="As of `validate`; each needs a closed form, or a proof to its end (default: six "
            "with a closed form).",
            autocompletion=complete_scene,
        ),
    ] = None,
    engine: Annotated[
        list[str] | None,
        engines_option("ours, pymunk in four ways and pybullet in three, and the proof"),
    ] = None,
    repeats: Annotated[
        int,
        typer.Option(
            min=1,
            help="Rounds: each begins the shot at another part of a step, and the least time "
            "counts; what takes long is run twice.",
        ),
    ] = 4,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="DIR", help="Write it there, as precision.json."),
    ] = None,
    plot: Annotated[
        Path | None,
        plot_option(
            "Draw the error against the steps in a second of play, and ring and name the step that "
            "is worth it"
        ),
    ] = None,
    form: PlainFormat = Plain.TEXT,
) -> None:
    """Measure each engine's error against its time, and say which step is worth it.

    An engine whose settings have a step, `dt`, plays each shot in steps from 20 ms down, each half
    as long as the one before; one without a step plays it once. The error is the largest distance
    of a ball from where it truly ends. All is done in this very process, one run after another, for
    times need that: some minutes for the engines that are the default. Exit status 4 where none of
    the engines can play any of the scenes.
    """


@app.command()
@runs("measure.elsewhere", "grade")
def grade(
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE...",
            help="Files of runs made elsewhere, as JSON: one run, a list, or one a line.",
        ),
    ],
) -> None:
    """Judge runs that an engine in any language made, as those of any other engine.

    `ghostball scenes --export DIR` writes the scenes. Each run is a JSON object: engine, scene (a
    shipped one's name, or all of it), status ("rest", "t-max"), rest_time, rest_positions, events
    and samples of the motion; reference_adapters/elsewhere.py describes all. A file holds one run,
    a list of them, or one a line. They are asked what
    `ghostball validate` asks of any engine, and the exit status is the same.
    """
