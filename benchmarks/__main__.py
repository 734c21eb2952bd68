"""How fast and how exact our own engine is: `python -m benchmarks COMMAND`, from a checkout."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated, TypeVar

import typer

from benchmarks.accuracy import SHOTS, measure_accuracy
from benchmarks.board import board_of
from benchmarks.breaks import BREAKS, measure_breaks
from benchmarks.fits import TABLES, measure_fits
from benchmarks.made import BREAKS as MADE, measure_made
from benchmarks.measurements import Shown, machine_folder
from benchmarks.pictures.gallery import write_gallery
from benchmarks.racks import PEERS, measure_racks, our_player, peer
from benchmarks.rebounds import measure_rebounds
from benchmarks.skips import measure_skips
from benchmarks.speed import chosen_workloads, measure_targets
from ghostball.cli.shared.options import AUTO, Jobs
from ghostball.cli.shared.progress import counting
from ghostball.cli.shared.terminal import command, say, stdout
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.results.measurement import MeasurementError, make_folder
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.gases import many_balls
from ghostball.validation.scenes.library import select

app = typer.Typer(
    name="benchmarks",
    help="Measure the speed and the accuracy of ghostball's own engine.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
)

M = TypeVar("M", bound=Shown)

Repeats = Annotated[
    int, typer.Option(min=1, help="Rounds: how often each is measured; slow ones less often.")
]
Out = Annotated[
    Path | None,
    typer.Option("--out", "-o", metavar="DIR", help="Write the measurement there, as JSON."),
]
Store = Annotated[
    bool,
    typer.Option(
        "--store", help="Write it to benchmarks/results/MACHINE of the checkout, to be committed."
    ),
]
Scenes = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="SCENE|TAG",
        help="As of `validate` (default: all that are shipped, and two of 256 balls).",
    ),
]


def measured_by(
    measure: Callable[..., M], out: Path | None, store: bool, *, part: bool = False
) -> M:
    """Measure, show it, and write it; `part` says that it isn't the whole measurement."""
    if store and part:
        raise MeasurementError(
            "`--store` keeps whole measurements only, so it can't go with single workloads or "
            "scenes, `--first`, fewer `--shots` or a smaller `--count` than by default, or "
            "`--peer`. Use `--out DIR`"
        )
    folders = [folder for folder in (out, machine_folder() if store else None) if folder]
    for folder in folders:
        make_folder(folder)
    with counting("measuring") as count:
        measured = measure(progress=count)
    stdout().print(measured.table)
    for folder in folders:
        stdout().print(f"written: {measured.save(folder)}", soft_wrap=True, markup=False)
    return measured


@app.command()
@command
def targets(
    wanted: Annotated[
        list[str] | None,
        typer.Argument(metavar="GLOB", help="Only workloads that match, such as 'gas-*'."),
    ] = None,
    repeats: Repeats = 15,
    out: Out = None,
    store: Store = False,
) -> None:
    """Measure our engine against its targets, some four minutes; a missed one is no failure."""
    measure = partial(measure_targets, chosen_workloads(wanted or ()), rounds=repeats)
    measured_by(measure, out, store, part=bool(wanted))


@app.command()
@command
def racks(
    repeats: Repeats = 5,
    out: Out = None,
    store: Store = False,
    peers: Annotated[
        list[str] | None,
        typer.Option(
            "--peer",
            metavar="ENGINE",
            help="Another engine beside ours, as for `run --engine`; once for each, or none for "
            f"none (default: {', '.join(PEERS)}).",
        ),
    ] = None,
) -> None:
    """Measure the time of each of 1000 random racks, half frozen.

    The other half is loose by up to 1 mm; all of pool's physics, the cue ball at 4 to 12 m/s. Other
    engines play the first 100 of them, once.
    """
    asked = PEERS if peers is None else [] if peers == ["none"] else peers
    measure = partial(measure_racks, our_player(), list(map(peer, asked)), rounds=repeats)
    measured_by(measure, out, store, part=peers is not None)


@app.command()
@command
def made(
    count: Annotated[int, typer.Option(min=1, help="How many breaks.")] = MADE,
    out: Out = None,
    store: Store = False,
) -> None:
    """Count how often a break on a bar table makes a ball, beside published counts."""
    measured_by(partial(measure_made, count), out, store, part=count < MADE)


@app.command()
@command
def breaks(
    count: Annotated[int, typer.Option(min=1, help="How many breaks.")] = BREAKS,
    out: Out = None,
    store: Store = False,
) -> None:
    """Play a million random breaks with all of pool's physics, on all cores, and time it all."""
    measured_by(partial(measure_breaks, count), out, store, part=count < BREAKS)


@app.command()
@command
def rebounds(out: Out = None, store: Store = False) -> None:
    """Search how near each engine can come to rebounds measured on a real table."""
    measured_by(measure_rebounds, out, store)


@app.command()
@command
def fits(
    tables: Annotated[int, typer.Option(min=1, help="How many tables.")] = TABLES,
    jobs: Jobs = AUTO,
    out: Out = None,
    store: Store = False,
) -> None:
    """Fit synthetic tables of known physics, and count how often the stated errors hold."""
    measured_by(partial(measure_fits, tables, jobs), out, store, part=tables < TABLES)


@app.command()
@command
def accuracy(
    shots: Annotated[int, typer.Option(min=1, help="How many random shots.")] = SHOTS,
    first: Annotated[
        int, typer.Option(min=0, help="Number of the first shot: the same number, the same shot.")
    ] = 0,
    jobs: Jobs = AUTO,
    out: Out = None,
    store: Store = False,
) -> None:
    """Prove random shots and grade our engine by them; exit with 1 if it breaks a limit."""
    measure = partial(measure_accuracy, shots, first=first, jobs=jobs)
    measured = measured_by(measure, out, store, part=first > 0 or shots < SHOTS)
    if measured.faulty:
        say(f"[bold red]Shots that break a limit of every scene: {len(measured.faulty)}[/]")
        raise typer.Exit(ExitStatus.CHECK_FAILED)


@app.command()
@command
def skips(
    scenes: Scenes = None, repeats: Repeats = 5, out: Out = None, store: Store = False
) -> None:
    """Run scenes with each skip off and on; exit with 1 where one changes an answer."""
    chosen = [*select(scenes)] if scenes else [*select(), *many_balls()]
    measure = partial(measure_skips, chosen, rounds=repeats)
    measured = measured_by(measure, out, store, part=bool(scenes))
    if measured.defects:
        say(f"[bold red]Answers that a skip changes: {len(measured.defects)};[/] see above")
        raise typer.Exit(ExitStatus.CHECK_FAILED)


@app.command()
@command
def board(
    results: Annotated[
        Path, typer.Argument(metavar="DIR", help="Results of `ghostball validate board`.")
    ],
    out: Out = None,
    store: Store = False,
) -> None:
    """Gather how right and how fast each engine is on the board, for the documentation."""
    measured_by(partial(board_of, Results.open(results)), out, store)


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
