"""`ghostball stress`: generate extreme shots, run them as `validate` does, print the failures."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

from rich.console import RenderableType
from rich.markup import escape

from ghostball.cli.measure.commands import StressOptions
from ghostball.cli.options import Format
from ghostball.cli.shared.config import load_config, named_engines
from ghostball.cli.shared.relations import relations_of, relations_table, say_never_judged
from ghostball.cli.shared.report import print_for_programs
from ghostball.cli.shared.running import run_cases, say_all_printed
from ghostball.cli.shared.tables import table_of
from ghostball.cli.shared.terminal import say, stdout, tables
from ghostball.reference_adapters.registry import OURS
from ghostball.reports.page.stress import FOLDER
from ghostball.validation.checks.verdict import not_judged
from ghostball.validation.exit_status import ExitStatus, worst
from ghostball.validation.results.files import write_files
from ghostball.validation.results.store import Results
from ghostball.validation.runs.starts_files import Shard, parquet_of
from ghostball.validation.stress import (
    DEFAULT_ENGINES,
    FAMILIES,
    StressShot,
    StressSize,
    chosen_shots,
    path_of,
    run_stress,
)
from ghostball.validation.stress.tally import (
    FamilyTally,
    again,
    explaining,
    sweeps,
    tallies,
    why_failed,
)
from ghostball.validation.suite.suite import SuiteResult, exit_status_of

FAULTS_SHOWN = 3
"""Number of failed shots printed for an engine in a family; the rest are counted."""


def run(asked: StressOptions) -> ExitStatus:
    """Run the shots, print where engines fail, and return the exit status."""
    shots = chosen_shots(StressSize(asked.full, asked.seed, asked.count), asked.only or ())
    shard = Shard.parse(asked.shard) if asked.shard is not None else None
    if shard is not None:
        number, shots = len(shots), shots[shard.index - 1 :: shard.count]
        if not shots:
            raise shard.no_shots(number)
    if asked.listed:
        show_list(shots, named=bool(asked.only), as_json=asked.form is Format.JSON)
        return ExitStatus.PASSED
    config = load_config()
    named = named_engines(asked.engine, config)
    folder = asked.out or config.out / FOLDER
    labels = named or DEFAULT_ENGINES
    relations = relations_of(asked.relations)
    outcome = run_cases(
        run_stress,
        shots,
        labels,
        folder,
        asked,
        cluster=asked.cluster,
        relations=relations,
    )
    if shard is not None:
        _write_shard(outcome, folder / shard.file_name("cases"))
    _show(outcome, asked.form)
    if relations is not None:
        tables(asked.form).print(relations_table(outcome.cases))
    print_for_programs(folder, asked.form)
    if outcome.interrupted:
        say(
            f"[bold]Interrupted:[/] {len(outcome.cases)} of {outcome.planned} shots are done and "
            f"stored in {escape(str(folder))}. Run the same command to continue."
        )
        return ExitStatus.INTERRUPTED
    # Default engines other than Ghostball's are for comparison: they need not pass.
    held = [case for case in outcome.cases if case.label in (named or (OURS,))]
    if why := not_judged(held):
        say(f"[bold yellow]{escape(why)}.[/]")
    return worst(exit_status_of(held), say_never_judged(held, relations))


def _write_shard(outcome: SuiteResult, file: Path) -> None:
    """Write the cases of a shard as Parquet."""
    mine = {case.scene for case in outcome.cases}
    frame = Results.open(outcome.folder).to_frame()
    frame = frame.filter([scene in mine for scene in frame["scene"]])
    write_files({file: parquet_of(frame)}, "Choose another `--out`")
    say(f"{len(frame)} cases written to {escape(str(file))}")


def show_list(shots: Sequence[StressShot], *, named: bool, as_json: bool) -> None:
    """Print the families, or the shots if families are named."""
    paths = [path_of(one.scene.name) for one in shots]
    if as_json:
        print(json.dumps({"families": list(FAMILIES), "shots": paths}))
    elif named:
        print(*paths, sep="\n")
    else:
        heads = ("family", "shots", "requirement")
        rows = (
            (one.name, str(sum(path.startswith(f"{one.name}/") for path in paths)), one.asks)
            for one in FAMILIES.values()
        )
        stdout().print(table_of(heads, rows, right=heads[1:2]))


def _show(outcome: SuiteResult, form: Format) -> None:
    """Print the counts for each family, the value where each engine starts to fail, and failures.

    A failure is printed as the name of the shot and the reason.
    """
    console, found = tables(form), tallies(outcome.cases)
    labels = list(dict.fromkeys(case.label for case in outcome.cases))
    heads = ("family", *map(escape, labels))
    families = list(dict.fromkeys(family for family, _ in found))
    rows = (
        (family, *(_cell(found.get((family, label), FamilyTally())) for label in labels))
        for family in families
    )
    console.print(table_of(heads, rows, right=heads[1:], title="passed / judged"))
    varied = [
        (f"{one.family}: {one.parameter}", *(one.fails[label] or "–" for label in labels))
        for one in sweeps(outcome.cases)
    ]
    if varied:
        console.print(table_of(("varied", *heads[1:]), varied, title="where engines fail"))
    for part in _failures(found, outcome.folder):
        console.print(part, soft_wrap=True)
    say_all_printed(outcome.cases)


def _cell(one: FamilyTally) -> str:
    if one.failed:
        return f"[bold red]{one.text}[/]"
    return f"[green]{one.text}[/]" if one.count("passed") else f"[dim]{one.text}[/]"


def _failures(found: dict[tuple[str, str], FamilyTally], folder: Path) -> Iterator[RenderableType]:
    """Yield the first failed shots of each engine in each family, and commands to repeat them."""
    for (family, label), one in found.items():
        for case in one.failed[:FAULTS_SHOWN]:
            where = f"{path_of(case.scene)} on {label}"
            yield f"[bold red]failed[/]  {escape(f'{where}: {why_failed(case)}')}"
        if one.failed:
            first = one.failed[0]
            more = len(one.failed) - FAULTS_SHOWN
            rest = f"{more} more shots of {family} failed; " if more > 0 else ""
            yield f"        {escape(f'{rest}to repeat: {again(first)}')}"
            yield f"        {escape(f'to explain: {explaining(first, folder)}')}"
