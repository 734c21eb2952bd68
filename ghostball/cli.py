"""The command line: reads options, calls the packages that do the work, shows what they return."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ghostball import _bench
from ghostball._options import (
    AsJson,
    BaselineFolder,
    ClusterAddress,
    EngineSpec,
    Figures,
    RecordChoice,
    SceneName,
    ShotLimit,
    StressSuite,
    SuiteChoice,
    check_plot,
    engines_option,
    jobs_option,
    plot_option,
)
from ghostball._terminal import ExitStatus, command, say, stdout

app = typer.Typer(
    name="ghostball",
    help="Runs the same billiard shots on several physics engines and shows which one is right.",
    epilog=(
        "Exit status: 0 all passed; 1 a check failed, or an engine failed, crashed, hung or did "
        "not finish; 2 bad usage or bad input; 3 ghostball itself failed; 4 nothing was judged, "
        "or there is nothing to compare with; 130 interrupted."
    ),
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    # Plain help and one-line errors, also where a CI pretends to be a terminal.
    rich_markup_mode=None,
)
app.add_typer(_bench.app)


def main() -> None:
    """Run the command line and exit."""
    app()


def _print_version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version  # noqa: PLC0415

        typer.echo(f"ghostball {version('ghostball')}")
        raise typer.Exit


@app.callback()
def _options(
    _version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version and exit."
        ),
    ] = False,
) -> None:
    """Hold the options that come before a command."""


@app.command()
@command
def simulate(
    scene: SceneName,
    engine: EngineSpec = "ghostball",
    record: Annotated[
        RecordChoice | None,
        typer.Option(
            help="What to keep: where the balls end, also each event (--json prints them), or also "
            "the whole motion (default: rest; with --plot: trajectory)."
        ),
    ] = None,
    as_json: AsJson = False,
    plot: Annotated[Path | None, plot_option("Draw the paths of the balls")] = None,
    explain_skips: Annotated[
        bool,
        typer.Option(
            "--explain-skips",
            help="Print also what our engine left out because the scene doesn't need it, and why. "
            "To switch some off: --engine ghostball:no_skip=contacts+cushions.",
        ),
    ] = False,
    time_limit: ShotLimit = 600.0,
) -> None:
    """Run one scene on one engine; print where the balls stop.

    Exit status 1 where the engine fails, crashes, hangs or doesn't come to the end of the shot.
    """
    if explain_skips and as_json:
        raise typer.BadParameter("--json and --explain-skips exclude each other")
    if plot is not None:
        if record not in (None, RecordChoice.TRAJECTORY):
            raise typer.BadParameter(
                f"--plot needs --record trajectory, got {record.value}", param_hint="--record"
            )
        record = RecordChoice.TRAJECTORY
        check_plot(plot)
    from ghostball._simulate import run  # noqa: PLC0415

    raise typer.Exit(
        run(
            scene,
            engine,
            record=(record or RecordChoice.REST).value,
            as_json=as_json,
            plot=plot,
            explain_skips=explain_skips,
            time_limit=time_limit,
        )
    )


@app.command()
@command
def validate(
    scenes: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="SCENE|TAG",
            help="Names or tags of shipped scenes (`ghostball scenes` lists both), or TOML files, "
            "instead of a suite. The pass criteria of shot.toml are in shot.expect.toml beside it.",
        ),
    ] = None,
    suite: Annotated[
        SuiteChoice | None,
        typer.Option(help="Which shipped scenes run: those tagged smoke, or all (default: full)."),
    ] = None,
    engines: Annotated[str | None, engines_option("pymunk and pybullet in three ways each")] = None,
    out: Annotated[
        Path,
        typer.Option(
            metavar="DIR",
            help="Folder of the results. What it already holds is replaced, but for cases that are "
            "unchanged: those aren't run again.",
        ),
    ] = Path("out"),
    metrics: Annotated[
        str | None,
        typer.Option(
            metavar="A,B,...",
            help="Metrics that are computed and judged, such as rest_error_max,energy_* (default: "
            "all). Limits on others are left out, and counted.",
        ),
    ] = None,
    rerun: Annotated[
        bool, typer.Option("--rerun", help="Run every case, also those that are unchanged.")
    ] = False,
    junit: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the verdicts as JUnit XML.")
    ] = None,
    jobs: Annotated[int, jobs_option("run and draw scenes; run times are cleanest with 1")] = 1,
    cluster: ClusterAddress = None,
    time_limit: Annotated[
        float,
        typer.Option(
            metavar="SECONDS",
            help="How long a scene may take on an engine. Each runs in a process of its own: one "
            "that takes longer, or crashes, is marked, and the others go on.",
        ),
    ] = 600.0,
    report: Annotated[
        bool, typer.Option(help="Write report.html, report.md and figures after the run.")
    ] = True,
    figures: Figures = False,
    ensemble: Annotated[
        int | None,
        typer.Option(
            metavar="K",
            help="Then also perturb each scene K times, run that on every engine, and compare how "
            "the shots end with our engine's distributions, such as `validate chaos --ensemble "
            "20`: for shots too chaotic to be compared one by one.",
        ),
    ] = None,
    ensemble_size: Annotated[
        str | None,
        typer.Option(
            metavar="SIZE",
            help="How far they are perturbed at most: speed and direction (relative, rad), and x "
            "and y of each ball (m) (default: velocity=1e-3,position=1e-4).",
        ),
    ] = None,
) -> None:
    """Run scenes on several engines; say which are right.

    Exit status 1 where a limit is broken, or an engine fails, crashes, hangs or doesn't come to the
    end of a shot; 4 where no limit covers what was run, so that nothing was judged.
    """
    from ghostball._validate import run  # noqa: PLC0415
    from ghostball.validation.parallel.cluster import cluster_at  # noqa: PLC0415

    if scenes and suite is not None:
        raise typer.BadParameter("scenes and --suite exclude each other", param_hint="--suite")
    if figures and not report:
        raise typer.BadParameter(
            "--figures and --no-report exclude each other", param_hint="--figures"
        )
    if ensemble_size is not None and ensemble is None:
        raise typer.BadParameter(
            "needs --ensemble K: how many times each scene is perturbed",
            param_hint="--ensemble-size",
        )
    with cluster_at(cluster) as there:
        status = run(
            scenes or [],
            suite=(suite or SuiteChoice.FULL).value,
            engines=engines,
            out=out,
            metrics=metrics,
            rerun=rerun,
            junit=junit,
            jobs=jobs,
            cluster=there,
            time_limit=time_limit,
            report=report,
            figures=figures,
            ensemble=ensemble,
            ensemble_size=ensemble_size,
        )
    raise typer.Exit(status)


@app.command()
@command
def explain(
    scene: SceneName,
    engine: EngineSpec,
    as_json: AsJson = False,
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
            help="Say also what the difference is made of, and which other stroke would explain "
            "it. Takes some two dozen runs, the finest at an eighth of the step or less."
        ),
    ] = True,
    time_limit: ShotLimit = 600.0,
) -> None:
    """Say where an engine's shot leaves the true one, and why.

    The truth is certified where it can be. Named are the first collision that one of both lacks,
    what the other has in its place, by how much, and the balls there; then what the difference is
    made of (model, step, rounding), by how much the engine played another shot, and with which step
    or mode it would play this one better. Exit status 0, whether they part or not; 1 where the
    engine fails, crashes, hangs or doesn't come to the end of the shot.
    """
    if plot is not None:
        check_plot(plot)
    from ghostball._explain import run  # noqa: PLC0415

    raise typer.Exit(
        run(
            scene,
            engine,
            as_json=as_json,
            plot=plot,
            attribute=attribute,
            time_limit=time_limit,
        )
    )


@app.command()
@command
def stress(
    only: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="FAMILY|FAMILY/TRIAL",
            help="Families (`ghostball stress --list` names them) or single trials, also as "
            "patterns such as 'grazing/*-miss-*' (default: all).",
        ),
    ] = None,
    suite: Annotated[
        StressSuite, typer.Option(help="quick: what a CI has time for; full: all of it.")
    ] = StressSuite.QUICK,
    engines: Annotated[str | None, engines_option("pymunk and pybullet in two ways each")] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Folder of what is found (default: out/stress-quick or out/stress-full). A run "
            "goes on where an earlier one by the same code ended.",
        ),
    ] = None,
    jobs: Annotated[int, jobs_option("try")] = 2,
    cluster: ClusterAddress = None,
    rerun: Annotated[
        bool, typer.Option("--rerun", help="Try everything, also what is known already.")
    ] = False,
    time_limit: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS",
            help="How long a trial may take (default: each has a limit of its own, a minute or "
            "more): after that it is ended, and has broken the engine.",
        ),
    ] = None,
    as_json: AsJson = False,
    listed: Annotated[
        bool,
        typer.Option(
            "--list",
            help="List the families and what they ask, or the trials of those that are named, and "
            "try nothing.",
        ),
    ] = False,
    report: Annotated[
        bool, typer.Option(help="Write stress.md and its figures after the run.")
    ] = True,
) -> None:
    """Try to break engines; say what each survives, with the worst case of all as a scene.

    Exit status 1 where our engine breaks; where it isn't asked, where any engine does; 4 where no
    engine can be asked any of it.
    """
    from ghostball import _stress  # noqa: PLC0415
    from ghostball.validation.parallel.cluster import cluster_at  # noqa: PLC0415

    if listed:
        _stress.show_list(only or [], suite=suite.value, as_json=as_json)
        return
    with cluster_at(cluster) as there:
        status = _stress.run(
            only or [],
            suite=suite.value,
            engines=engines,
            out=Path(f"out/stress-{suite.value}") if out is None else out,
            jobs=jobs,
            cluster=there,
            rerun=rerun,
            time_limit=time_limit,
            as_json=as_json,
            report=report,
        )
    raise typer.Exit(status)


@app.command()
@command
def regress(
    scenes: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="SCENE|TAG",
            help="Names or tags of shipped scenes, or TOML files (default: all that are shipped, "
            "and two shots of 256 balls).",
        ),
    ] = None,
    against: Annotated[
        str | None,
        typer.Option(
            metavar="REV",
            help="Compare with another revision instead of the baselines: both run by turns, so "
            "that run times are compared too.",
        ),
    ] = None,
    baselines: BaselineFolder = None,
    out: Annotated[
        Path, typer.Option(metavar="DIR", help="Folder of the results, to be reported on.")
    ] = Path("out/regress"),
    junit: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write what changed as JUnit XML.")
    ] = None,
    jobs: Annotated[int, jobs_option("run scenes")] = 1,
    rerun: Annotated[
        bool, typer.Option("--rerun", help="Run every scene, also those that are unchanged.")
    ] = False,
    time_limit: Annotated[
        float, typer.Option(metavar="SECONDS", help="How long a scene may take.")
    ] = 600.0,
    times: Annotated[
        bool, typer.Option(help="With --against: time the scenes too, both sides by turns.")
    ] = True,
    as_json: AsJson = False,
) -> None:
    """Say what changed in our engine since its baselines were accepted.

    Each scene is identical, rounding only (within what its conditioning explains, up to its
    horizon), changed, or better or worse against truth; named are the first event that differs and
    what moved. Exit status 1 where a deterministic number moved: an event, a bit, a counter, an
    error against truth; 4 where a scene can't be compared, such as one that has no baseline.
    """
    from ghostball._regress import run  # noqa: PLC0415

    raise typer.Exit(
        run(
            scenes or [],
            against=against,
            baselines=baselines,
            out=out,
            junit=junit,
            jobs=jobs,
            rerun=rerun,
            time_limit=time_limit,
            timed=times,
            as_json=as_json,
        )
    )


@app.command()
@command
def accept(
    reason: Annotated[
        str, typer.Option(metavar="TEXT", help="Why the change is right; kept in CHANGES.md.")
    ],
    only: Annotated[
        str, typer.Option(metavar="GLOB", help="Accept only scenes that match, such as 'break-*'.")
    ] = "*",
    results: Annotated[
        Path,
        typer.Option("--from", metavar="DIR", help="What `regress --out` wrote and you looked at."),
    ] = Path("out/regress"),
    baselines: BaselineFolder = None,
    even_though_limits_fail: Annotated[
        bool,
        typer.Option(
            "--even-though-limits-fail",
            help="Accept also what breaks limits of truth, which is wrong and not only another "
            "answer.",
        ),
    ] = False,
) -> None:
    """Accept what `regress` found: rewrite the baselines that moved, and note why.

    Exit status 1, and nothing is written, where limits of truth are broken.
    """
    from ghostball._regress import run_accept  # noqa: PLC0415

    raise typer.Exit(
        run_accept(
            results,
            reason,
            only=only,
            baselines=baselines,
            even_though_limits_fail=even_though_limits_fail,
        )
    )


@app.command()
@command
def report(
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="DIR", help="A folder that `validate`, `regress` or `stress` wrote."
        ),
    ],
    jobs: Annotated[int, jobs_option("draw")] = 1,
    figures: Figures = False,
    summary: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help='Instead, add a summary in Markdown to FILE, such as "$GITHUB_STEP_SUMMARY": the '
            "verdict, what changed, what failed, all verdicts. - is stdout.",
        ),
    ] = None,
    text: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Instead, write what is wrong to FILE in plain text, a line each: "
            "`SCENE: LEVEL: MESSAGE`. - is stdout.",
        ),
    ] = None,
) -> None:
    """Write report.html and report.md, or stress.md, and figures again from stored results.

    With --summary or --text only these are written, for a CI to show.
    """
    if summary is not None or text is not None:
        from ghostball._summary import write  # noqa: PLC0415

        write(folder, summary=summary, text=text)
        return
    from ghostball import _report  # noqa: PLC0415
    from ghostball.validation.results.database import documents_in  # noqa: PLC0415

    if documents_in(folder) == {"stress"}:
        from ghostball.reports import write_stress_report  # noqa: PLC0415

        typer.echo(write_stress_report(folder))
        return
    written = _report.write(folder, jobs=jobs, figures=figures)
    typer.echo(written.page)
    typer.echo(written.report)
    raise typer.Exit(written.status())


@app.command()
@command
def export(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder of a run, of any command that has --out.")
    ],
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder of the files (default: DIR/export)."),
    ] = None,
) -> None:
    """Write the results of a run as JSON lines and CSV, a file for each table.

    Such as cases, checks, metrics and events; print the files. `Results.open(DIR).to_frame()` gives
    Python the same tables as data frames.
    """
    from ghostball.validation.results.frames import export as write  # noqa: PLC0415

    for path in write(folder, folder / "export" if out is None else out):
        typer.echo(path)


@app.command()
@command
def history(
    kind: Annotated[
        str,
        typer.Argument(
            metavar="KIND",
            help="Which measurement: targets, scaling, racks, skips, accuracy, attribution, "
            "precision or stress.",
        ),
    ] = "targets",
    quantity: Annotated[
        str | None,
        typer.Option(metavar="GLOB", help="Only quantities that match, such as 'break-*/kernel'."),
    ] = None,
    plot: Annotated[
        Path | None, plot_option("Draw a panel for each quantity, over the revisions")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Show committed measurements (benchmarks/results) over the revisions they were made at.

    Each committed version of each machine's file is read from git. × is the ratio to the version
    before, = the same to the bit.
    """
    if plot is not None:
        check_plot(plot)
    from ghostball._history import run  # noqa: PLC0415

    raise typer.Exit(run(kind, pattern=quantity, plot=plot, as_json=as_json))


@app.command()
@command
def scenes(
    schema: Annotated[
        bool, typer.Option("--schema", help="Print the JSON schema of scene files instead.")
    ] = False,
) -> None:
    """List the shipped scenes, or print their schema."""
    if schema:
        from ghostball.engine.scene import json_schema  # noqa: PLC0415

        typer.echo(json_schema())
        return
    from ghostball._tables import scenes_table  # noqa: PLC0415
    from ghostball.validation.scenes.library import select  # noqa: PLC0415

    stdout().print(scenes_table(select()))


@app.command()
@command
def engines() -> None:
    """List the engines: settings, and what each represents."""
    from ghostball._tables import engines_list  # noqa: PLC0415

    for block in engines_list():
        stdout().print(block)


@app.command()
@command
def doctor() -> None:
    """Check the installation; exit status 1 where it is broken."""
    from ghostball._doctor import examine  # noqa: PLC0415

    findings, healthy = examine()
    stdout().print(findings)
    if not healthy:
        say("[bold red]Something is broken;[/] see above.")
        raise typer.Exit(ExitStatus.CHECK_FAILED)
