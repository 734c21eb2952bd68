"""Options and help of `run`, `validate`, `explain`, `fit`, `stress` and `grade`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from ghostball.cli.options import (
    ClusterAddress,
    EngineSpec,
    FigureChoice,
    Figures,
    OriginChoice,
    RecordChoice,
    Relations,
    SceneName,
    SceneNames,
    ShardOption,
    ShotOptions,
    SuiteOptions,
    engine_option,
    engines_option,
    out_option,
    plot_option,
    scene_argument,
)
from ghostball.cli.shared.calls import command

app = typer.Typer()


@command(app, "measure.run")
@dataclass(frozen=True)
class RunOptions(ShotOptions):
    """Simulate one scene on one engine; print the rest positions.

    Exit status 1 if the engine does not finish (exception, crash, time limit), or if the hash
    differs from --expect-hash.
    """

    context: typer.Context
    scene: SceneName
    engine: EngineSpec = "ghostball"
    record: Annotated[
        RecordChoice | None,
        typer.Option(
            help="What to record. rest: the rest positions; events: also the events (--format "
            "json prints them); trajectory: also the whole motion (default: rest; on a table with "
            "pockets: events; with --plot: trajectory)."
        ),
    ] = None
    plot: Annotated[
        Path | None,
        plot_option(
            "Draw the paths of the balls, or write a film",
            ".png, .svg or .pdf; for a film .gif or .mp4",
        ),
    ] = None
    expect_hash: Annotated[
        str | None,
        typer.Option(
            metavar="HASH",
            help="Fail if the hash of the events and rest positions differs from HASH "
            "(`--record events` prints the hash).",
        ),
    ] = None
    starts: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Simulate the scene once for each row of a CSV or Parquet file, and write the "
            "outcomes to a Parquet file: columns speed, direction, elevation, offset_left and "
            "offset_up of strokes; or states of balls, such as cue.x, cue.vx and cue.wx. Needs: "
            "pip install '.[frames]' in a clone of Ghostball.",
        ),
    ] = None
    shard: ShardOption = None
    out: Annotated[
        Path | None, out_option("For --starts: folder of the Parquet files (default: shots).")
    ] = None
    cluster: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            help="For --starts: the scheduler of a Dask cluster whose workers simulate the shots, "
            "as for `validate`.",
        ),
    ] = None


@command(app, "measure.validate")
@dataclass(frozen=True)
class ValidateOptions(SuiteOptions):
    """Run scenes on several engines and check the results.

    Exit status 1 if a check failed, or an engine did not finish (exception, crash, time limit); 4
    if no limit applies, so nothing was judged.
    """

    scenes: SceneNames = None
    engine: Annotated[
        list[str] | None,
        engines_option(
            "ghostball, pymunk and pybullet in three configurations each, and the paper's two "
            "algorithms"
        ),
    ] = None
    out: Annotated[
        Path | None,
        out_option(
            "Results folder. Existing results are replaced; unchanged cases are reused (default: "
            "out)."
        ),
    ] = None
    metric: Annotated[
        list[str] | None,
        typer.Option(
            "--metric",
            metavar="GLOB",
            help="Metric to compute and check, such as rest_error_max or 'energy_*'; repeatable "
            "(default: all; `ghostball scenes --metrics` lists them). Limits on other metrics "
            "aren't checked; the command prints how many.",
        ),
    ] = None
    cluster: ClusterAddress = None
    report: Annotated[bool, typer.Option(help="Write report.html after the run.")] = True
    figures: Figures = FigureChoice.NONE
    relations: Relations = None
    ensemble: Annotated[
        int | None,
        typer.Option(
            metavar="K",
            help="Also simulate each scene from K perturbed initial states, and compare the "
            "distributions of the results with those of Ghostball's engine. Use it for chaotic "
            "shots: `validate chaos --ensemble 40`. Exit status 1 if an engine that claims to be "
            "exact differs.",
        ),
    ] = None
    ensemble_size: Annotated[
        str | None,
        typer.Option(
            metavar="SIZE",
            help="Largest perturbation of each ball: `velocity` for the speed (relative) and the "
            "direction (rad), `position` for x and y (m) (default: "
            "velocity=1e-3,position=1e-4).",
        ),
    ] = None
    details: Annotated[
        bool,
        typer.Option(
            "--details",
            help="For each scene and engine, compare rest positions, collisions and energy with "
            "the reference.",
        ),
    ] = False


@command(app, "measure.explain")
@dataclass(frozen=True)
class ExplainOptions(ShotOptions):
    """Find the cause of an engine's error and the first wrong collision.

    The cause is a wrong coefficient, such as a friction that is 5/7 of the right one; the time
    step, if the error shrinks with a shorter one; or different physics. The reference is certified
    if possible. Exit status 0, even if collisions are wrong; 1 if the engine does not finish
    (exception, crash, time limit).
    """

    scene: Annotated[
        str | None,
        scene_argument(
            "SCENE",
            "Name of a shipped scene, or a TOML file (default: the worst scene of the last run).",
        ),
    ] = None
    engine: Annotated[
        str | None,
        engine_option(
            "Engine, as for `run` (default: the first of [tool.ghostball] in pyproject.toml)."
        ),
    ] = None
    plot: Annotated[
        Path | None,
        plot_option(
            "Draw both shots at the time of the first wrong collision, with the collisions marked"
        ),
    ] = None
    attribute: Annotated[
        bool,
        typer.Option(
            help="Find the cause of the error, such as the engine's time step or its model. "
            "The command makes two or three more runs, with time steps down to a sixteenth or less "
            "of the engine's own time step."
        ),
    ] = True


@command(app, "measure.fit")
@dataclass(frozen=True)
class FitOptions(ShotOptions):
    """Fit the physics of a real table to tracks of its balls.

    The fit uses events in which nothing else disturbs a ball: a ball rolls, hits one cushion, or
    hits a ball at rest. The engine simulates each event, and the fitted values minimize the
    differences from the tracks. Needs: pip install '.[fit]' in a clone of Ghostball. Exit status 2
    if there are too few events.
    """

    tracks: Annotated[
        Path,
        typer.Argument(
            metavar="TRACKS.csv",
            help="CSV file of ball positions with the header shot,ball,t,x,y, in seconds and "
            "metres from one corner of the playing surface. Lines that begin with # are comments.",
        ),
    ]
    table: Annotated[
        tuple[float, float],
        typer.Option(
            metavar="LENGTH WIDTH", help="Playing surface between the cushions, along x and y [m]."
        ),
    ]
    radius: Annotated[float, typer.Option(metavar="R", help="Radius of the balls [m].")]
    origin: Annotated[
        OriginChoice,
        typer.Option(help="Origin of x and y: a corner or the centre of the playing surface."),
    ] = OriginChoice.CORNER
    columns: Annotated[
        str | None,
        typer.Option(
            metavar="NAME=COLUMN,...",
            help="Columns of the file for shot, ball, t, x and y, if they have other names, such "
            "as t=time,x=pos_x. The file may then have more columns.",
        ),
    ] = None
    fields: Annotated[
        str | None,
        typer.Option(
            metavar="A,B,...",
            help="Fields of the physics to fit (default: frictions of the cloth, restitutions, and "
            "the friction of cushions, as far as the tracks determine them).",
        ),
    ] = None
    preset: Annotated[
        str, typer.Option(metavar="NAME", help="Preset for the values that aren't fitted.")
    ] = "pool"
    law: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Cushion law, named as in [physics] (default: the law that fits best, or the "
            "preset's law if the tracks can't decide).",
        ),
    ] = None
    nose_height: Annotated[
        float | None,
        typer.Option(
            metavar="METRES",
            help="Measured height of the cushion's nose above the cloth. Without it, the preset's "
            "height is assumed, and the errors allow for the range in the rules of pool.",
        ),
    ] = None
    engine: EngineSpec = "ghostball"
    out: Annotated[
        Path | None,
        out_option(
            "Write the fitted [physics] table as TOML, with standard errors in comments.", "FILE"
        ),
    ] = None
    plot: Annotated[Path | None, plot_option("Draw the residual of each event")] = None


@command(app, "measure.stress")
@dataclass(frozen=True)
class StressOptions(SuiteOptions):
    """Generate extreme shots; show where each engine fails.

    Each shot has the limits that apply to every engine, and limits on values that are known for the
    shot. The first shot that fails on an engine is saved as a scene. `ghostball report out` writes
    a report with a section about the shots. The exit status is the same as for `validate`; it
    depends on the engines that `--engine` names, or on Ghostball's own if none is named.
    """

    only: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="FAMILY|FAMILY/SHOT",
            help="Families (`ghostball stress --list` names them) or single shots, or patterns "
            "such as 'grazing/*-miss-*' (default: all).",
        ),
    ] = None
    engine: Annotated[
        list[str] | None,
        engines_option(
            "ghostball, pymunk and pybullet in two configurations each, and the paper's two "
            "algorithms"
        ),
    ] = None
    full: Annotated[
        bool,
        typer.Option(
            "--full", help="All shots, not only the selection that is short enough for CI."
        ),
    ] = False
    seed: Annotated[
        int, typer.Option(metavar="N", min=0, help="Number of the first random shot.")
    ] = 0
    count: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=1,
            help="Number of random breaks (default: 100; with --full: 5000).",
        ),
    ] = None
    relations: Relations = None
    out: Annotated[
        Path | None,
        out_option(
            "Results folder. A run continues an earlier run of the same code (default: out/stress)."
        ),
    ] = None
    cluster: ClusterAddress = None
    shard: ShardOption = None
    listed: Annotated[
        bool,
        typer.Option(
            "--list",
            help="List the families and their requirements, or the shots of named families; run "
            "nothing.",
        ),
    ] = False


@command(app, "measure.grade")
@dataclass(frozen=True)
class GradeOptions:
    """Check results that an engine in any language has written.

    The limits and the exit status are those of `validate`. `ghostball scenes --export DIR` writes
    the scenes. Each run is a JSON object: engine, scene (a shipped name, or the whole scene),
    status ("rest", "t-max"), rest_time, rest_positions, events and samples of the motion; see
    reference_adapters/answer.py.

    With --golden, the files are answers to golden shots instead. Shots without an answer are
    counted, not failed. Exit status: 0 all answers pass, 1 some fail, 2 unreadable, 4 no answers.
    """

    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE...",
            help="JSON files of results: one run, a list of runs, or one run per line. With "
            "--golden: an object of answers by name, or a folder with a file NAME.json per answer.",
        ),
    ]
    golden: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Compare answers with the golden shots in DIR, as its README describes.",
        ),
    ] = None
    factor: Annotated[
        float | None,
        typer.Option(
            metavar="X",
            help="For --golden: multiply all tolerances by X (536870912 for single precision).",
        ),
    ] = None
