"""What `ghostball validate --ensemble` does beyond the suite: perturb, run, compare, show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rich import box
from rich.console import Console, Group, RenderableType
from rich.markup import escape
from rich.table import Table

from ghostball._progress import COMPILING, Steps
from ghostball._terminal import say
from ghostball.engine import Scene
from ghostball.reports import style
from ghostball.reports.page.ensembles import effect_text, without_end_text
from ghostball.validation.ensembles import (
    QUANTITIES,
    REFERENCE,
    Compared,
    Comparison,
    EnsembleRecord,
    Ensembles,
    MemberResult,
    Size,
    check_ensembles,
    compare,
    run_ensembles,
)
from ghostball.validation.ensembles.compare import LEVEL
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.parallel.cluster import Cluster

PERTURBING, COMPARING = "perturbed shots", "comparing"
"""The steps."""


@dataclass(frozen=True)
class EnsembleRequest:
    """What was asked for, checked: members of each ensemble and the size of the perturbation."""

    count: int
    size: Size

    @classmethod
    def checked(
        cls,
        count: int,
        size: str | None,
        scenes: Sequence[Scene],
        labels: Sequence[str],
        out: Path,
    ) -> EnsembleRequest:
        """Read the options.

        Raises
        ------
        GhostballError
            Where one is wrong, or the folder holds ensembles that can't be read.
        """
        asked = cls(count, Size() if size is None else Size.parse(size))
        check_ensembles(scenes, labels, out, asked.count, asked.size)
        return asked


def run(
    request: EnsembleRequest,
    scenes: Sequence[Scene],
    labels: Sequence[str],
    out: Path,
    *,
    jobs: int,
    cluster: Cluster | None,
    rerun: bool,
    time_limit: float,
    steps: Steps,
) -> ExitStatus:
    """Run the ensembles into a results folder that the suite wrote, and return the exit status."""
    failing: set[tuple[str, str]] = set()
    with steps.bar(PERTURBING) as step:
        count = step(PERTURBING)

        def progress(done: int, planned: int, result: MemberResult) -> None:
            count(done, planned, f"{result.scene}, {result.index}, on {result.label}")
            where = (result.scene, result.label)
            if result.outcome == "failed" and where not in failing:
                failing.add(where)  # once: it may well fail on every member
                shot = escape(f"{result.scene}, perturbed ({result.index}), on {result.label}")
                say(f"[bold red]crashed[/] {shot}: {escape(result.reason)}")

        outcome = run_ensembles(
            scenes,
            labels,
            out,
            request.count,
            size=request.size,
            jobs=jobs,
            cluster=cluster,
            progress=progress,
            compiling=step(COMPILING),
            reuse=not rerun,
            time_limit=time_limit,
        )
    if outcome.taken_over:
        say(
            f"{outcome.taken_over} of {outcome.planned} perturbed shots unchanged, taken over from "
            f"{escape(str(out))} (run again with --rerun)"
        )
    if outcome.interrupted:
        kept = f"{outcome.done} of {outcome.planned} perturbed shots are done and kept in"
        say(
            f"[bold]Interrupted:[/] {kept} {escape(str(out))}; the same command goes on from there"
            if outcome.begun
            else f"[bold]Interrupted[/] before the first perturbed shot: {escape(str(out))} has "
            "the ensembles that it had"
        )
        return ExitStatus.INTERRUPTED
    return ExitStatus.CHECK_FAILED if outcome.failed else ExitStatus.PASSED


def show(out: Path, console: Console, steps: Steps) -> ExitStatus:
    """Print what the ensembles of a results folder say; return the exit status of their check."""
    ensembles = Ensembles.load(out)
    assert ensembles is not None  # a run has just written them
    with steps.bar(COMPARING) as step:
        step(COMPARING)(0, 1, "")
        compared = compare(ensembles)
    console.print(_tables(ensembles, compared))
    passed = compared.null.passed
    colour = {True: "green", False: "bold red", None: "yellow"}[passed]
    sentence = escape(compared.null.sentence)
    console.print(f"null test of {REFERENCE} [{colour}]{sentence}[/]", soft_wrap=True)
    return ExitStatus.CHECK_FAILED if passed is False else ExitStatus.PASSED


def _tables(ensembles: Ensembles, compared: Compared) -> RenderableType:
    run = ensembles.run
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("scene", no_wrap=True)
    table.add_column("engine", no_wrap=True)
    table.add_column("ended", justify="right")
    table.add_column("rest positions\ndistance", justify="right")
    for name in QUANTITIES.values():
        table.add_column(f"{name}\neffect".replace(" collisions", ""), justify="right")
    remarks: list[str] = []
    for scene in run.scenes:
        name = scene
        remarks += _unable(scene, ensembles.of(scene))
        for record in (*ensembles.of(scene, "null").values(), *ensembles.of(scene).values()):
            if without := without_end_text(record):
                remarks.append(escape(f"{scene} on {record.label}: {without}"))
            comparisons = compared.of(scene, record.label, record.stream)
            if not comparisons:
                continue
            rest = comparisons[0]
            table.add_row(
                name,
                escape(record.label) + (" (null test)" if record.stream == "null" else ""),
                f"{rest.ended} of {run.count}",
                "–" if rest.test is None else style.format_length(rest.test.distance),
                *map(_effect_cell, comparisons),
            )
            name = ""
    tests = sum(one.test is not None for one in compared.comparisons)
    key = (
        f"[dim]Ensembles of {run.count} shots, perturbed by {escape(str(run.size))}, against "
        f"{REFERENCE}: a comparison of codes, not with truth.\n"
        "Effect: energy distance as a part of the most it could be, 0 where distributions are the "
        f"same; ≠ where p < {LEVEL:g}, corrected for {tests} tests; ? where there are too few "
        "members for that[/]"
    )
    return Group(table, key, *remarks)


def _effect_cell(one: Comparison) -> str:
    if one.differs:
        return f"[bold]≠ {effect_text(one)}[/]"
    return effect_text(one) if one.judged or one.test is None else f"? {effect_text(one)}"


def _unable(scene: str, records: Mapping[str, EnsembleRecord]) -> list[str]:
    """Name the engines on which a scene did not run; the report has the reasons, which are long."""
    labels: dict[str, list[str]] = {}
    for label, record in records.items():
        if record.outcome != "ran":
            labels.setdefault(record.outcome.replace("-", " "), []).append(label)
    return [
        escape(f"{scene}: {outcome} (the report says why): {', '.join(those)}")
        for outcome, those in labels.items()
    ]
