"""How fast and how exact our own engine is: `python -m benchmarks COMMAND`, from a checkout."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated, TypeVar

import typer
from rich.console import RenderableType

import benchmarks.accuracy
from benchmarks import measurements, tables
from benchmarks.measurements import Measurement
from benchmarks.pictures.gallery import write_gallery
from benchmarks.precision import _ladders, measure as precision_of
from benchmarks.precision.tables import precision_tables
from benchmarks.racks import PEERS, RACKS, measure_racks, our_player, peer
from benchmarks.running import BenchError
from benchmarks.skips import measure_skips
from benchmarks.speed import chosen_workloads, measure_targets
from ghostball.cli.shared.options import AUTO, Jobs, engines_option
from ghostball.cli.shared.progress import counting
from ghostball.cli.shared.terminal import command, say, stdout
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.results.environment import describe_environment
from ghostball.validation.scenes.gases import many_balls
from ghostball.validation.scenes.library import select

app = typer.Typer(
    name="benchmarks",
    help="Measure the speed and the accuracy of ghostball's own engine.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
)

M = TypeVar("M", bound=Measurement)

ROUNDS = 15
"""Rounds of the targets: some four minutes, three of which compile."""

Repeats = Annotated[
    int, typer.Option(min=1, help="Rounds: how often each is measured; slow ones less often.")
]
Quick = Annotated[
    bool, typer.Option("--smoke", help="Tiny sizes, to see that all runs; its times mean nothing.")
]
Out = Annotated[
    Path | None,
    typer.Option("--out", "-o", metavar="FILE|DIR", help="Write the measurement there, as JSON."),
]
Store = Annotated[
    bool,
    typer.Option(
        "--store", help="Write it to benchmarks/results/MACHINE of the checkout, to be committed."
    ),
]
Workloads = Annotated[
    list[str] | None,
    typer.Argument(metavar="GLOB", help="Only workloads that match, such as 'gas-*'."),
]
Peers = Annotated[
    list[str] | None,
    typer.Option(
        "--peer",
        metavar="ENGINE",
        help="Another engine beside ours, as for `run --engine`; once for each, or none for none "
        f"(default: {', '.join(PEERS)}).",
    ),
]
Shots = Annotated[
    int | None, typer.Option(min=1, help="How many random shots (default: all that --store keeps).")
]
First = Annotated[
    int, typer.Option(min=0, help="Number of the first shot: the same number, the same shot.")
]


def paths_of(kind: str, out: Path | None, store: bool, *, part: bool) -> dict[str, Path]:
    """Return the files to write, by option, each checked before anything is measured."""
    paths: dict[str, Path] = {}
    if store:
        if part:
            raise BenchError(
                "`--store` keeps whole measurements only, so it can't go with `--smoke`, "
                "single workloads, `--first`, fewer `--shots` than by default, `--engine`, or "
                "single scenes. Use `--out FILE`"
            )
        paths["--store"] = measurements.store_path(describe_environment(), kind)
    if out is not None:
        paths["--out"] = measurements.out_path(out, kind)
    for option, path in paths.items():
        measurements.check_target(path, kind, option)
    return paths


def measured_by(
    measure: Callable[..., M], tables: Callable[[M], RenderableType], paths: dict[str, Path]
) -> M:
    """Measure, show it, and write it; end with 130 where that was interrupted."""
    with counting("measuring") as count:
        measured = measure(progress=count)
    stdout().print(tables(measured))
    for option, path in paths.items():
        if measured.interrupted and not measured.anything:
            continue
        if measured.interrupted and option == "--store":
            say("[bold]Interrupted:[/] nothing is stored, for a part would replace the whole")
            continue
        measurements.save(measured, path, option)
        stdout().print(f"written: {path}", soft_wrap=True, markup=False)
    if measured.interrupted:
        say("[bold]Interrupted:[/] the tables hold what was measured until then")
        raise typer.Exit(ExitStatus.INTERRUPTED)
    return measured


@app.command()
@command
def targets(
    wanted: Workloads = None,
    repeats: Repeats = ROUNDS,
    quick: Quick = False,
    out: Out = None,
    store: Store = False,
) -> None:
    """Measure our engine against its targets; a missed one is no failure."""
    measure = partial(
        measure_targets,
        chosen_workloads(wanted or ()),
        rounds=1 if quick else repeats,
        quick=quick,
    )
    paths = paths_of("targets", out, store, part=bool(wanted) or quick)
    measured_by(measure, tables.targets_tables, paths)


@app.command()
@command
def racks(
    repeats: Repeats = 5,
    quick: Quick = False,
    out: Out = None,
    store: Store = False,
    peers: Peers = None,
) -> None:
    """Measure the time of each of 1000 random racks, half frozen.

    The other half is loose by up to 1 mm; all of pool's physics, the cue ball at 4 to 12 m/s. Other
    engines play the first 100 of them, once.
    """
    paths = paths_of("racks", out, store, part=quick)
    asked = PEERS if peers is None else [] if peers == ["none"] else peers
    measure = partial(
        measure_racks,
        our_player(),
        [peer(one) for one in asked],
        rounds=1 if quick else repeats,
        racks=2 if quick else RACKS,
    )
    measured_by(measure, tables.racks_tables, paths)


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
    for path in write_gallery(results, out, sections_dir=sections):
        typer.echo(path)


if __name__ == "__main__":
    app()
