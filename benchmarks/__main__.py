"""How fast and how exact our own engine is: `python -m benchmarks COMMAND`, from a checkout."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

import benchmarks.accuracy
import benchmarks.attribution
from benchmarks import tables
from benchmarks.board import draw_committed_board
from benchmarks.commands import Out, Quick, Repeats, Store, measured_by, paths_of
from benchmarks.flight_racks import FLIGHTS, measure_flights, told
from benchmarks.gallery import write_gallery
from benchmarks.measure import measure_targets
from benchmarks.peer_engines import make_peers
from benchmarks.precision import _ladders, measure as precision_of
from benchmarks.precision.figure import draw_committed_precision
from benchmarks.precision.tables import precision_tables
from benchmarks.racks import RACKS, measure_racks
from benchmarks.racks_figure import draw_committed_racks
from benchmarks.scaling import TINY, WIDE, measure_scaling
from benchmarks.scaling_figure import draw_committed_scaling
from benchmarks.sizes import FULL, QUICK
from benchmarks.skips import measure_skips
from benchmarks.targets import chosen_workloads
from ghostball._options import AUTO, Jobs, engines_option
from ghostball._terminal import command, say, stdout
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.scenes.gases import many_balls
from ghostball.validation.scenes.library import select

app = typer.Typer(
    name="benchmarks",
    help="Measure the speed and the accuracy of ghostball's own engine.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
)

ROUNDS = 15
"""Rounds of the targets: some six minutes without peers, three of which compile."""

Workloads = Annotated[
    list[str] | None,
    typer.Argument(metavar="GLOB", help="Only workloads that match, such as 'gas-*'."),
]
Peers = Annotated[
    list[str] | None,
    typer.Option(
        "--peer",
        metavar="NAME|ENGINE",
        help="Another engine beside ours: pooltool, billiards, FastFiz, or as for `run --engine`; "
        "give it once for each, or none for none (default: all that are known).",
    ),
]
Shots = Annotated[
    int | None, typer.Option(min=1, help="How many random shots (default: all that --store keeps).")
]
First = Annotated[
    int, typer.Option(min=0, help="Number of the first shot: the same number, the same shot.")
]


@app.command()
@command
def targets(
    wanted: Workloads = None,
    repeats: Repeats = ROUNDS,
    quick: Quick = False,
    out: Out = None,
    store: Store = False,
    peer: Peers = None,
) -> None:
    """Measure our engine against its targets, and peers beside it; a missed one is no failure."""
    measure = partial(
        measure_targets,
        chosen_workloads(wanted or ()),
        rounds=1 if quick else repeats,
        size=QUICK if quick else FULL,
    )
    paths = paths_of("targets", out, store, part=bool(wanted) or quick)
    measured_by(partial(measure, make_peers(peer)), tables.targets_tables, paths)


@app.command()
@command
def scaling(
    repeats: Repeats = 3,
    quick: Quick = False,
    out: Out = None,
    store: Store = False,
    peer: Peers = None,
) -> None:
    """Measure time per event against number of balls and packing."""
    paths = paths_of("scaling", out, store, part=quick)
    measure = partial(
        measure_scaling,
        make_peers(peer),
        rounds=1 if quick else repeats,
        extent=TINY if quick else WIDE,
    )
    measured_by(measure, tables.scaling_tables, paths)


@app.command()
@command
def racks(
    repeats: Repeats = 5,
    quick: Quick = False,
    out: Out = None,
    store: Store = False,
    peer: Peers = None,
) -> None:
    """Measure the time of each of 1000 random racks, half frozen.

    The other half is loose by up to 1 mm; all of pool's physics, the cue ball at 4 to 12 m/s. Peers
    play the first 100 of them, once.
    """
    paths = paths_of("racks", out, store, part=quick)
    measure = partial(
        measure_racks,
        make_peers(peer),
        rounds=1 if quick else repeats,
        racks=2 if quick else RACKS,
    )
    measured_by(measure, tables.racks_tables, paths)


@app.command(name="flight-racks")
@command
def flight_racks(
    repeats: Repeats = 3,
    quick: Quick = False,
    shots: Annotated[int, typer.Option(min=1, help="How many.")] = FLIGHTS,
) -> None:
    """Measure the time and the work of random shots in flight onto frozen racks."""
    stdout().print(told(measure_flights(2 if quick else shots, 1 if quick else repeats)))


@app.command()
@command
def accuracy(
    shots: Shots = None, first: First = 0, jobs: Jobs = AUTO, out: Out = None, store: Store = False
) -> None:
    """Prove 10 000 random shots and grade our engine by them; exit with 1 if it breaks a limit."""
    shots = shots or benchmarks.accuracy.SHOTS
    paths = paths_of("accuracy", out, store, part=first > 0 or shots < benchmarks.accuracy.SHOTS)
    measure = partial(benchmarks.accuracy.measure_accuracy, shots, first=first, jobs=jobs)
    measured = measured_by(measure, tables.accuracy_tables, paths)
    if measured.faulty:
        say(f"[bold red]Shots that break a limit of every scene: {len(measured.faulty)}[/]")
        raise typer.Exit(ExitStatus.CHECK_FAILED)


@app.command()
@command
def attribution(
    shots: Shots = None, first: First = 0, jobs: Jobs = AUTO, out: Out = None, store: Store = False
) -> None:
    """Count how often the bound of a model error that `explain` gives holds.

    200 random shots on engines whose model error is known. Exit status 1 where fewer than 95 % of
    the bounds hold.
    """
    shots = shots or benchmarks.attribution.SHOTS
    paths = paths_of(
        "attribution", out, store, part=first > 0 or shots < benchmarks.attribution.SHOTS
    )
    measure = partial(benchmarks.attribution.measure_attribution, shots, first=first, jobs=jobs)
    measured = measured_by(measure, tables.attribution_tables, paths)
    if measured.failing:
        say(f"[bold red]Too few bounds hold:[/] {', '.join(measured.failing)}")
        raise typer.Exit(ExitStatus.CHECK_FAILED)


@app.command()
@command
def skips(
    scenes: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="SCENE|TAG",
            help="As of `validate` (default: all that are shipped, and two of 256 balls).",
        ),
    ] = None,
    repeats: Repeats = 5,
    out: Out = None,
    store: Store = False,
) -> None:
    """Run scenes with each skip off and on; exit with 1 where one changes an answer."""
    chosen = [*select(scenes)] if scenes else [*select(), *many_balls()]
    paths = paths_of("skips", out, store, part=bool(scenes))
    measured = measured_by(
        partial(measure_skips, chosen, rounds=repeats), tables.skips_tables, paths
    )
    if measured.defects:
        say(f"[bold red]Answers that a skip changes: {len(measured.defects)};[/] see above")
        raise typer.Exit(ExitStatus.CHECK_FAILED)


@app.command()
@command
def precision(
    scenes: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="SCENE|TAG",
            help="Names or tags of shipped scenes, or TOML files, each with a closed form or "
            "proved to its end (default: six with closed forms).",
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
    quick: Quick = False,
    out: Out = None,
    store: Store = False,
) -> None:
    """Measure each engine's error against its time, from long steps to short ones.

    The error is the largest distance of a ball from where it truly ends. Some minutes.
    """
    asked = engine or precision_of.PRECISION_ENGINES
    chosen = select(scenes or (precision_of.QUICK_SCENES if quick else precision_of.DEFAULT_SCENES))
    paths = paths_of("precision", out, store, part=bool(scenes) or engine is not None or quick)
    measure = partial(
        precision_of.measure_precision,
        chosen,
        asked,
        rounds=1 if quick else repeats,
        extent=_ladders.TINY if quick else _ladders.WIDE,
    )
    measured_by(measure, precision_tables, paths)


@app.command()
@command
def gallery(
    results: Annotated[Path, typer.Argument(metavar="DIR", help="Results of the full suite.")],
    out: Annotated[Path, typer.Argument(metavar="GALLERY", help="Folder of the pictures.")],
    sections: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Results to draw the paper's section 6 from."),
    ] = None,
) -> None:
    """Draw the pictures that the README shows, and those of committed benchmarks beside them."""
    more = {
        "precision": draw_committed_precision,
        "scaling": draw_committed_scaling,
        "racks": draw_committed_racks,
        "board": draw_committed_board,
    }
    for path in write_gallery(results, out, more, sections_dir=sections):
        typer.echo(path)


if __name__ == "__main__":
    app()
