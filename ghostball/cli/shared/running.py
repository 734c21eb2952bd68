"""Run the cases of `validate`, `regress` and `stress`, with a bar and messages about reuse."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rich.markup import escape

from ghostball.cli.options import SuiteOptions
from ghostball.cli.shared.progress import COMPILING, RUNNING, Steps
from ghostball.cli.shared.terminal import say, say_printed
from ghostball.reports.words import many
from ghostball.validation.parallel.cluster import cluster_at
from ghostball.validation.parallel.sources import is_ours
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.runs.runner import Reuse
from ghostball.validation.suite.suite import SuiteResult


def run_cases(
    run: Callable[..., SuiteResult],
    items: Sequence[Any],
    labels: Sequence[str],
    out: Path,
    asked: SuiteOptions,
    *,
    cluster: str | None = None,
    steps: Steps | None = None,
    done: Callable[[CaseRecord], None] = lambda _: None,
    **more: Any,
) -> SuiteResult:
    """Run cases with a progress bar, and print how many are reused.

    `run`: `run_suite`, or a function with the same parameters.
    `items`: first argument of `run`.
    `more`: further arguments of `run`.
    `steps`: the steps of the whole command, if it has more than compiling and running.
    `done`: called after each case.
    """
    with cluster_at(cluster) as there, (steps or Steps(COMPILING, RUNNING)).bar() as step:
        count = step(RUNNING)

        def progress(number: int, planned: int, case: CaseRecord) -> None:
            count(number, planned, f"{case.scene} on {case.label}")
            done(case)

        return run(
            items,
            labels,
            out,
            jobs=asked.jobs,
            cluster=there,
            progress=progress,
            compiling=step(COMPILING),
            reuse=not asked.rerun,
            announce=lambda reused: _announce(reused, labels, out),
            time_limit=asked.time_limit,
            **more,
        )


def _announce(reused: Reuse[CaseRecord], labels: Sequence[str], out: Path) -> None:
    """Print how many cases are reused, or why none is although results are stored."""
    if reused.records:
        say(reused_text(len(reused.records), out))
    elif reused.stored or reused.why:
        why = reused.why or "every case differs in its scene, settings, limits or metrics"
        say(f"nothing was reused from {escape(str(out))}: {escape(why)}")
    if reused.stored and (always := [label for label in labels if not is_ours(label)]):
        say(
            "these engines run again every time, because Ghostball can't detect changes in their "
            f"code: {escape(', '.join(always))}"
        )


def reused_text(count: int, out: Path) -> str:
    """Return a message with the number of reused cases."""
    return f"{many(count, 'case')} reused from {escape(str(out))} (--rerun runs them again)"


def say_all_printed(cases: Sequence[CaseRecord]) -> None:
    """Show what each engine printed in its first scene with output, and count the others."""
    for label in dict.fromkeys(case.label for case in cases if case.printed):
        mine = [case for case in cases if case.label == label and case.printed]
        say_printed(label, mine[0].printed)
        others = many(len(mine) - 1, "more case")
        more = f", and in {others}, listed in the report" * (len(mine) > 1)
        say(escape(f"engine {label} printed this in scene {mine[0].scene}{more}"))
