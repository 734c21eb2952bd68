"""The commands that play shots and say how right they are."""

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
    RecordChoice,
    SceneName,
    SceneNames,
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
    """Run one scene on one engine; print where the balls stop.

    Exit status 1 where the engine fails, crashes, hangs or doesn't come to the end of the shot, or
    where the shot has another hash than was expected.
    """

    scene: SceneName
    engine: EngineSpec = "ghostball"
    record: Annotated[
        RecordChoice | None,
        typer.Option(
            help="Keep rest positions, also each event (--format json prints them), or also the "
            "whole motion (default: rest; with --plot: trajectory)."
        ),
    ] = None
    plot: Annotated[
        Path | None, plot_option("Draw the paths of the balls; .gif and .mp4 are films of the shot")
    ] = None
    expect_hash: Annotated[
        str | None,
        typer.Option(
            metavar="HASH",
            help="Fail unless events and rest positions have this hash (see `--record events`).",
        ),
    ] = None


@command(app, "measure.validate")
@dataclass(frozen=True)
class ValidateOptions(SuiteOptions):
    """Run scenes on several engines; say which are right.

    Exit status 1 where a limit is broken, or an engine fails, crashes, hangs or doesn't come to the
    end of a shot; 4 where no limit covers what was run, so that nothing was judged.
    """

    scenes: SceneNames = None
    engine: Annotated[
        list[str] | None,
        engines_option(
            "ghostball, pymunk and pybullet in three ways each, and the paper's two algorithms"
        ),
    ] = None
    out: Annotated[
        Path | None,
        out_option(
            "Folder of the results. Existing results are replaced; unchanged cases are reused "
            "(default: out)."
        ),
    ] = None
    metric: Annotated[
        list[str] | None,
        typer.Option(
            "--metric",
            metavar="GLOB",
            help="Metrics that are computed and judged, such as rest_error_max or 'energy_*'; give "
            "it once for each (default: all; `ghostball scenes --metrics` lists them). Limits on "
            "others are left out, and counted.",
        ),
    ] = None
    cluster: ClusterAddress = None
    report: Annotated[bool, typer.Option(help="Write report.html after the run.")] = True
    figures: Figures = FigureChoice.NONE
    ensemble: Annotated[
        int | None,
        typer.Option(
            metavar="K",
            help="Also simulate each scene from K perturbed initial states, and compare the spread "
            "of the ends. Use it for chaotic shots: `validate chaos --ensemble 20`.",
        ),
    ] = None
    ensemble_size: Annotated[
        str | None,
        typer.Option(
            metavar="SIZE",
            help="How far starts are varied at most: speed and direction (relative, rad), and x "
            "and y of each ball (m) (default: velocity=1e-3,position=1e-4).",
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

    Causes are a coefficient, such as a friction, with its factor; the time step, if the error
    shrinks with a shorter one; and different physics. The reference is certified if possible. Exit
    status 0, even if collisions are wrong; 1 if the engine fails, crashes, hangs or doesn't finish.
    """

    scene: Annotated[
        str | None,
        scene_argument(
            "SCENE", "Name of a shipped scene, or a TOML file (default: the worst of the last run)."
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
            help="Find the cause of the error, such as the engine's step or its model. Takes two "
            "more runs or three, the finest at a sixteenth of the step or less."
        ),
    ] = True


@command(app, "measure.fit")
@dataclass(frozen=True)
class FitOptions(ShotOptions):
    """Fit the physics of a real table to tracks of its balls.

    The fit uses the clean events in the tracks: stretches of rolling, contacts with one cushion,
    hits of a ball at rest. The engine simulates each event, and the fitted values minimize the
    differences from all of them. Needs: pip install '.[fit]' in a clone of Ghostball. Exit status 2
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
            help="Cushion law, named as in [physics] (default: the best fit, or the preset's law "
            "if the tracks don't distinguish them).",
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
    """Try to break engines; say where each fails.

    The limits for every engine apply to generated shots, too, and so do limits on numbers that are
    known for each shot. The first shot that an engine fails is saved as a scene. `ghostball report
    out` writes a report with a section about the shots. The exit status is the same as for
    `validate`; it depends on the engines that `--engine` names, or on Ghostball's own if none is
    named.
    """

    only: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="FAMILY|FAMILY/SHOT",
            help="Families (`ghostball stress --list` names them) or single shots, also as "
            "patterns such as 'grazing/*-miss-*' (default: all).",
        ),
    ] = None
    engine: Annotated[
        list[str] | None,
        engines_option(
            "ghostball, pymunk and pybullet in two ways each, and the paper's two algorithms"
        ),
    ] = None
    full: Annotated[
        bool, typer.Option("--full", help="All shots, not only what a CI has time for.")
    ] = False
    seed: Annotated[
        int, typer.Option(metavar="N", min=0, help="Number of the first random shot.")
    ] = 0
    count: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=1,
            help="How many random breaks are generated (default: 100; with --full: 5000).",
        ),
    ] = None
    out: Annotated[
        Path | None,
        out_option(
            "Folder of the results. A run continues where an earlier one by the same code ended "
            "(default: out/stress)."
        ),
    ] = None
    cluster: ClusterAddress = None
    listed: Annotated[
        bool,
        typer.Option(
            "--list",
            help="List families and what they ask, or the shots of named families. Run nothing.",
        ),
    ] = False


@command(app, "measure.grade")
@dataclass(frozen=True)
class GradeOptions:
    """Judge runs that an engine in any language has written.

    The limits and the exit status are those of `validate`. `ghostball scenes --export DIR` writes
    the scenes. Each run is a JSON object: engine, scene (a shipped name, or the whole scene),
    status ("rest", "t-max"), rest_time, rest_positions, events and samples of the motion; see
    reference_adapters/answer.py.
    """

    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE...",
            help="JSON files of runs made elsewhere: one run, a list of runs, or one run per line.",
        ),
    ]
