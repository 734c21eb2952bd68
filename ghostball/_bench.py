"""`ghostball bench`: how quick our engine is, how exact, and what others take for that."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer

from ghostball._options import engines_option
from ghostball._terminal import ExitStatus, command, say, stdout

if TYPE_CHECKING:
    from rich.console import RenderableType

    from ghostball.validation.bench import Measurement
    from ghostball.validation.bench.peer_engines import Peer

    M = TypeVar("M", bound=Measurement)

app = typer.Typer(
    name="bench",
    help="Measure speed and accuracy: bare, our engine's speed against its targets, and peers.",
    add_completion=False,
    rich_markup_mode=None,
)

ROUNDS = 15
"""Rounds of the targets: some six minutes without peers, three of which compile."""

Only = Annotated[
    str | None,
    typer.Option("--only", metavar="GLOB", help="Measure only what matches, such as 'gas-*'."),
]
Repeats = Annotated[
    int, typer.Option(min=1, help="Rounds: how often each is measured; slow ones less often.")
]
Quick = Annotated[
    bool, typer.Option("--quick", help="Tiny sizes, to see that all runs; its times mean nothing.")
]
Out = Annotated[
    Path | None,
    typer.Option(metavar="FILE|DIR", help="Write the measurement there, as JSON."),
]
Store = Annotated[
    bool,
    typer.Option(
        "--store", help="Write it to benchmarks/results/MACHINE of the checkout, to be committed."
    ),
]
Peers = Annotated[
    str | None,
    typer.Option(
        metavar="A,B,...",
        help="Other engines beside ours: pooltool, billiards, FastFiz, or as for `simulate "
        "--engine`; none for none (default: all that are known).",
    ),
]
PeerPython = Annotated[
    Path | None,
    typer.Option(
        metavar="PATH",
        help="Interpreter that has pooltool and billiards (default: that of `make peers`).",
    ),
]

Shots = Annotated[
    int | None, typer.Option(min=1, help="How many random shots (default: all that --store keeps).")
]
First = Annotated[
    int, typer.Option(min=0, help="Number of the first shot: the same number, the same shot.")
]
Jobs = Annotated[int, typer.Option(min=1, help="Processes.")]


@app.callback(invoke_without_command=True)
@command
def targets(
    context: typer.Context,
    only: Only = None,
    repeats: Repeats = ROUNDS,
    quick: Quick = False,
    out: Out = None,
    store: Store = False,
    peers: Peers = None,
    peer_python: PeerPython = None,
) -> None:
    """Measure our engine against its targets, and peers beside it; a missed one is no failure."""
    if context.invoked_subcommand is not None:
        if any((only, out, store, peers, quick, peer_python)) or repeats != ROUNDS:
            name = context.invoked_subcommand
            raise typer.BadParameter(
                f"options go after `{name}`: `ghostball bench {name} --help` lists its own"
            )
        return
    from ghostball._bench_tables import targets_tables  # noqa: PLC0415
    from ghostball.validation import bench  # noqa: PLC0415

    workloads = bench.chosen_workloads(only)
    with _peers(peers, peer_python) as compared:
        paths = _paths("targets", out, store, part=only is not None or quick)
        measure = partial(
            bench.measure_targets,
            workloads,
            compared,
            rounds=1 if quick else repeats,
            size=bench.QUICK if quick else bench.FULL,
        )
        _measured(measure, targets_tables, paths)


@app.command()
@command
def scaling(
    repeats: Repeats = 3,
    quick: Quick = False,
    out: Out = None,
    store: Store = False,
    peers: Peers = None,
    peer_python: PeerPython = None,
) -> None:
    """Measure time per event against number of balls and packing."""
    from ghostball._bench_tables import scaling_tables  # noqa: PLC0415
    from ghostball.validation import bench  # noqa: PLC0415

    with _peers(peers, peer_python) as compared:
        paths = _paths("scaling", out, store, part=quick)
        measure = partial(
            bench.measure_scaling,
            compared,
            rounds=1 if quick else repeats,
            extent=bench.TINY if quick else bench.WIDE,
        )
        _measured(measure, scaling_tables, paths)


@app.command()
@command
def racks(
    repeats: Repeats = 5,
    quick: Quick = False,
    out: Out = None,
    store: Store = False,
    peers: Peers = None,
    peer_python: PeerPython = None,
) -> None:
    """Measure the time of each of 1000 random racks, half frozen.

    The other half is loose by up to 1 mm; all of pool's physics, the cue ball at 4 to 12 m/s. Peers
    play the first 100 of them, once.
    """
    from ghostball._bench_tables import racks_tables  # noqa: PLC0415
    from ghostball.validation import bench  # noqa: PLC0415

    with _peers(peers, peer_python) as compared:
        paths = _paths("racks", out, store, part=quick)
        measure = partial(
            bench.measure_racks,
            compared,
            rounds=1 if quick else repeats,
            racks=2 if quick else bench.RACKS,
        )
        _measured(measure, racks_tables, paths)


@app.command()
@command
def skips(
    scenes: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="SCENE|TAG",
            help="Names or tags of shipped scenes, or TOML files (default: all that are shipped, "
            "and two of 256 balls).",
        ),
    ] = None,
    repeats: Repeats = 5,
    out: Out = None,
    store: Store = False,
) -> None:
    """Run scenes with each skip off and on; exit with 1 where one changes an answer."""
    from ghostball._bench_tables import skips_tables  # noqa: PLC0415
    from ghostball.validation import bench  # noqa: PLC0415
    from ghostball.validation.scenes.library import select  # noqa: PLC0415

    chosen = [*select(scenes)] if scenes else [*select(), *bench.many_balls()]
    paths = _paths("skips", out, store, part=bool(scenes))
    measured = _measured(partial(bench.measure_skips, chosen, rounds=repeats), skips_tables, paths)
    if measured.defects:
        say(f"[bold red]Answers that a skip changes: {len(measured.defects)};[/] see above")
        raise typer.Exit(ExitStatus.CHECK_FAILED)


@app.command()
@command
def accuracy(
    shots: Shots = None, first: First = 0, jobs: Jobs = 2, out: Out = None, store: Store = False
) -> None:
    """Prove 10 000 random shots and grade our engine by them; exit with 1 if it breaks a limit."""
    from ghostball._bench_tables import accuracy_tables  # noqa: PLC0415
    from ghostball.validation.bench import accuracy as bench  # noqa: PLC0415

    shots = shots or bench.SHOTS
    paths = _paths("accuracy", out, store, part=first > 0 or shots < bench.SHOTS)
    measure = partial(bench.measure_accuracy, shots, first=first, jobs=jobs)
    measured = _measured(measure, accuracy_tables, paths)
    if measured.faulty:
        say(f"[bold red]Shots that break a limit of every scene: {len(measured.faulty)}[/]")
        raise typer.Exit(ExitStatus.CHECK_FAILED)


@app.command()
@command
def attribution(
    shots: Shots = None, first: First = 0, jobs: Jobs = 2, out: Out = None, store: Store = False
) -> None:
    """Count how often the bound of a model error that `explain` gives holds.

    200 random shots on engines whose model error is known. Exit status 1 where fewer than 95 % of
    the bounds hold.
    """
    from ghostball._bench_tables import attribution_tables  # noqa: PLC0415
    from ghostball.validation.bench import attribution as bench  # noqa: PLC0415

    shots = shots or bench.SHOTS
    paths = _paths("attribution", out, store, part=first > 0 or shots < bench.SHOTS)
    measure = partial(bench.measure_attribution, shots, first=first, jobs=jobs)
    measured = _measured(measure, attribution_tables, paths)
    if measured.failing:
        say(f"[bold red]Too few bounds hold:[/] {', '.join(measured.failing)}")
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
    engines: Annotated[
        str | None,
        engines_option("pymunk in four ways and pybullet in three, and the proof"),
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

    The error is the largest distance of a ball from where it truly ends. Some minutes. With --out
    RESULTS, a folder that `validate` wrote, it joins that folder's report.
    """
    from ghostball._precision_tables import precision_tables  # noqa: PLC0415
    from ghostball.reference_adapters import split_specs  # noqa: PLC0415
    from ghostball.validation import bench  # noqa: PLC0415
    from ghostball.validation.bench.precision import TINY, WIDE  # noqa: PLC0415
    from ghostball.validation.scenes.library import select  # noqa: PLC0415

    asked = bench.PRECISION_ENGINES if engines is None else split_specs(engines)
    chosen = select(scenes or (bench.QUICK_SCENES if quick else bench.DEFAULT_SCENES))
    paths = _paths("precision", out, store, part=bool(scenes) or engines is not None or quick)
    measure = partial(
        bench.measure_precision,
        chosen,
        asked,
        rounds=1 if quick else repeats,
        extent=TINY if quick else WIDE,
    )
    _measured(measure, precision_tables, paths)


@contextmanager
def _peers(names: str | None, python: Path | None) -> Iterator[Sequence[Peer]]:
    """Hand out the peers that are asked for, and close them whatever happens."""
    from ghostball.validation import bench  # noqa: PLC0415

    compared = bench.make_peers(names, python)
    try:
        yield compared
    finally:
        for peer in compared:
            peer.close()


def _paths(kind: str, out: Path | None, store: bool, *, part: bool) -> dict[str, Path]:
    """Return the files to write, by option, each checked before anything is measured."""
    from ghostball.validation.bench import BenchError, measurements  # noqa: PLC0415
    from ghostball.validation.results.environment import describe_environment  # noqa: PLC0415

    paths: dict[str, Path] = {}
    if store:
        if part:
            raise BenchError(
                "`--store` keeps whole measurements only, so it can't go with `--only`, `--quick`, "
                "`--first`, fewer `--shots` than by default, `--engines`, or single scenes. Use "
                "`--out FILE`"
            )
        paths["--store"] = measurements.store_path(describe_environment(), kind)
    if out is not None:
        paths["--out"] = measurements.out_path(out, kind)
    for option, path in paths.items():
        measurements.check_target(path, kind, option)
    return paths


def _measured(
    measure: Callable[..., M], tables: Callable[[M], RenderableType], paths: dict[str, Path]
) -> M:
    """Measure, show it, and write it; end with 130 where that was interrupted."""
    from ghostball._progress import counting  # noqa: PLC0415
    from ghostball.validation.bench import measurements  # noqa: PLC0415

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
