"""What `ghostball stress` does: try to break engines, show what each survives."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Group, RenderableType
from rich.markup import escape

from ghostball.cli.shared.config import load_config
from ghostball.cli.shared.options import Plain
from ghostball.cli.shared.progress import COMPILING, Steps
from ghostball.cli.shared.tables import table_of
from ghostball.cli.shared.terminal import say, stdout
from ghostball.reference_adapters import make_engine
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.parallel.cluster import cluster_at
from ghostball.validation.stress import (
    DEFAULT_ENGINES,
    FAMILIES,
    Finding,
    StressFolder,
    StressOutcome,
    Suite,
    run_stress,
)
from ghostball.validation.stress.families import chosen_trials, path_of
from ghostball.validation.stress.survival import (
    Survival,
    all_survival,
    scene_file,
    tracked_numbers,
    trying_again,
)
from ghostball.validation.stress.trial import Family

FAULTS_SHOWN = 3
"""How many broken trials of an engine in a family are named; the others are counted."""


def show_list(only: Sequence[str], *, suite: Suite, as_json: bool) -> None:
    """Print the families, or, where some are named, their trials."""
    if only:
        paths = [path_of(family, trial) for family, trial in chosen_trials(suite, only)]
        if as_json:
            print(json.dumps({"suite": suite, "trials": paths}))
        else:
            print(*paths, sep="\n")
        return
    counts = {name: _counts(family) for name, family in FAMILIES.items()}
    if as_json:
        families = [
            {"name": one.name, "title": one.title, "asks": one.asks, "trials": counts[one.name]}
            for one in FAMILIES.values()
        ]
        print(json.dumps({"families": families}))
        return
    heads = ("family", "trials, quick/full", "what an engine must do to survive")
    rows = (
        (one.name, "/".join(map(str, counts[one.name].values())), escape(one.asks))
        for one in FAMILIES.values()
    )
    stdout().print(table_of(heads, rows, right=heads[1:2]))


def _counts(family: Family) -> dict[str, int]:
    suites: tuple[Suite, ...] = ("quick", "full")
    return {suite: sum(1 for _ in family.trials(suite)) for suite in suites}


def run(
    only: Sequence[str] | None,
    engine: Sequence[str] | None,
    full: bool,
    out: Path | None,
    jobs: int,
    form: Plain,
    rerun: bool,
    cluster: str | None,
    time_limit: float | None,
    listed: bool,
) -> ExitStatus:
    """Run the suite, print what was survived, and return the exit status."""
    suite: Suite = "full" if full else "quick"
    if listed:
        show_list(only or (), suite=suite, as_json=form is Plain.JSON)
        return ExitStatus.PASSED
    config = load_config()
    named = tuple(engine or config.engines)
    labels = named or DEFAULT_ENGINES
    folder = config.out / f"stress-{suite}" if out is None else out
    for label in named:
        # Who names an engine wants its verdict; of the default ones, those that are here will do.
        make_engine(label)
    with cluster_at(cluster) as there, Steps(COMPILING, "trying").bar() as step:
        count = step("trying")

        def progress(done: int, planned: int, finding: Finding) -> None:
            count(done, planned, f"{finding.family}/{finding.trial} on {finding.label}")

        outcome = run_stress(
            labels,
            folder,
            suite=suite,
            only=only or (),
            must_hold=named or (OURS,),
            jobs=jobs,
            cluster=there,
            progress=progress,
            compiling=step(COMPILING),
            reuse=not rerun,
            time_limit=time_limit,
        )
    if outcome.reused:
        say(
            f"{outcome.reused} of {outcome.folder.planned} trials are known from an "
            "earlier run of the same code (--rerun tries them again)."
        )
    if form is Plain.JSON:
        print(json.dumps(summary(outcome)))
    else:
        for part in _tables(outcome):
            stdout().print(part)
    if outcome.interrupted:
        say(
            f"[bold]Interrupted:[/] {len(outcome.folder.findings)} of "
            f"{outcome.folder.planned} trials are done and kept in {escape(str(folder))}. The "
            "same command continues from there."
        )
    return outcome.exit_status


def summary(outcome: StressOutcome) -> dict[str, Any]:
    """Return what was survived as plain values."""
    folder = outcome.folder
    return {
        "suite": folder.run.suite,
        "planned": folder.planned,
        "done": len(folder.findings),
        "exit_status": outcome.exit_status,
        "wall_time": outcome.wall_time,
        "jobs": outcome.jobs,
        "reused": outcome.reused,
        "environment": folder.run.environment,
        "tracked": tracked_numbers(folder),
        "survival": [_survival(one, folder) for one in all_survival(folder)],
    }


def _survival(one: Survival, folder: StressFolder) -> dict[str, Any]:
    worst = one.worst
    return {
        "family": one.family,
        "engine": one.label,
        "trials": len(one.findings),
        "survived": one.count("survived"),
        "broken": one.count("broken"),
        "not_representable": one.count("not-representable"),
        "unavailable": one.count("unavailable"),
        "not_judged": one.count("failed", "not-judged"),
        "shots": sum(found.shots for found in one.findings),
        "broken_shots": sum(found.broken for found in one.findings),
        "seconds": sum(found.seconds for found in one.findings),
        "again": one.again,
        "worst": None
        if worst is None
        else {
            "trial": worst.trial,
            "outcome": worst.outcome,
            "faults": list(worst.faults),
            "severity": worst.severity,
            "scene": str(scene_file(worst, folder.path)),
            "command": one.command,
        },
    }


def _tables(outcome: StressOutcome) -> list[RenderableType]:
    folder = outcome.folder
    labels = [escape(label) for label in folder.run.labels]
    rows = (
        (
            FAMILIES[family].title,
            *(_cell(Survival(folder, family, label)) for label in folder.run.labels),
        )
        for family in folder.run.families
    )
    title = f"survived / tried, suite {folder.run.suite}"
    parts: list[RenderableType] = [table_of(("family", *labels), rows, right=labels, title=title)]
    for label in folder.run.labels:
        lines = [line for family in folder.run.families for line in _faults(folder, family, label)]
        if lines:
            parts.append(Group(f"[bold]{escape(label)}[/]:", *lines, ""))
    return parts


def _cell(one: Survival) -> str:
    if not one.count("survived", "broken", "failed", "not-judged"):
        return f"[dim]{one.text}[/]"
    if not one.count("survived", "broken", "failed"):
        return f"[bold yellow]{one.text}[/]"
    return f"[bold red]{one.text}[/]" if one.count("broken", "failed") else f"[green]{one.text}[/]"


def _faults(folder: StressFolder, family: str, label: str) -> list[str]:
    one = Survival(folder, family, label)
    broken = one.of("broken")
    lines = [
        f"  {escape(f'{family}/{found.trial}')}: {escape(found.faults[0])}"
        for found in broken[:FAULTS_SHOWN]
    ]
    if len(broken) > FAULTS_SHOWN:
        lines.append(f"  {family}: {len(broken) - FAULTS_SHOWN} more")
    commands = (one.command, one.again) if broken else ()
    lines += [f"    {escape(command)}" for command in commands if command is not None]
    lines += [
        f"  {escape(f'{family}/{found.trial}')} [bold]could not be judged:[/] "
        f"{escape(found.faults[0])}\n    {escape(trying_again(found, folder))}"
        for found in one.of("failed")
    ]
    lines += [
        f"  {escape(f'{family}/{found.trial}')} [bold]was not judged:[/] {escape(found.faults[0])}"
        for found in one.of("not-judged")[:FAULTS_SHOWN]
    ]
    return lines
