"""`ghostball diff`: compare two runs, or two engines of one run."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median

from rich.markup import escape
from rich.table import Table

from ghostball.cli.gate.commands import DiffOptions
from ghostball.cli.options import TextOrJson
from ghostball.cli.shared.config import load_config
from ghostball.cli.shared.tables import table_of
from ghostball.cli.shared.terminal import stdout
from ghostball.model import GhostballError
from ghostball.reports.error_changes import error_text
from ghostball.reports.outcome import CHANGES, coloured
from ghostball.reports.words import many
from ghostball.validation.baselines import SceneChange
from ghostball.validation.baselines.run_pairs import changes_of, paired
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.results.store import Results, has_results


def run(asked: DiffOptions) -> ExitStatus:
    """Compare two results folders, or two engines of one folder, and print the differences."""
    first, second = asked.first, asked.second
    base, head, labels = _sides(first, second, asked.out or load_config().out)
    found = paired(base, head, labels)
    times = [(one.wall_time, two.wall_time) for one, two in found if one and two]
    ratios = [after / before for before, after in times if before and after]
    return show(first, second, changes_of(base, head, found), ratios, asked.form)


def _sides(first: str, second: str, folder: Path) -> tuple[Results, Results, Mapping[str, str]]:
    """Return both runs, and the pairs of engine labels to compare; {} pairs equal labels."""
    folders = [Path(one) for one in (first, second)]
    if all(map(has_results, folders)):
        base, head = map(Results.open, folders)
        return base, head, {}
    for one, path in zip((first, second), folders, strict=True):
        if path.is_dir() or has_results(path):
            Results.open(path)  # raises an error that says what is wrong, if anything
            other = second if one == first else first
            raise GhostballError(
                f"{other}: not a results folder, but {one} is one. Give two results folders or two "
                "engines"
            )
    if not folder.exists():
        raise GhostballError(
            f"{first}: not a results folder, and {folder}, which would have the results of an "
            "engine with this name, doesn't exist. Give two results folders, or choose the folder "
            "of two engines with `--out`"
        )
    results = Results.open(folder)
    for one in (first, second):
        if one not in results.labels:
            raise GhostballError(
                f"{one}: neither a results folder nor an engine in {folder}, which has results of "
                f"{', '.join(results.labels)}. Choose another folder with `--out`"
            )
    return results, results, {first: second}


def show(
    first: str, second: str, found: Sequence[SceneChange], ratios: Sequence[float], form: TextOrJson
) -> ExitStatus:
    """Print the differences, and return the exit status.

    `ratios`: run times of the second side divided by those of the first, one for each shot.

    Raises `GhostballError` if the two sides have no scene in common.
    """
    if not found:
        raise GhostballError(
            f"{first} and {second} have no scene in common, so there is nothing to compare"
        )
    status = ExitStatus.CHECK_FAILED if any(one.failed for one in found) else ExitStatus.PASSED
    if form is TextOrJson.JSON:
        ratio = median(ratios) if ratios else None
        cases = [json.loads(one.model_dump_json()) for one in found]  # NaN and infinity as null
        sides = {"base": first, "head": second, "run_time_ratio": ratio, "cases": cases}
        print(json.dumps(sides))
        return status
    console = stdout()
    moved = [one for one in found if one.moved or one.metrics or one.broken]
    if moved:
        console.print(changes_table(moved))
    counts = Counter(one.words for one in moved)
    parts = [f"{len(found) - len(moved)} of {many(len(found), 'case')} unchanged"]
    parts += [f"{count} {words}" for words, count in counts.items()]
    if fail := sum(one.failed for one in found):
        parts.append(f"[bold red]{fail} failed: less accurate by a class, or failed a limit[/]")
    console.print(f"{', '.join(parts)}: {escape(first)} -> {escape(second)}", soft_wrap=True)
    if ratios:
        console.print(
            f"run time, {escape(second)} / {escape(first)}: median {median(ratios):.3g} in "
            f"{many(len(ratios), 'shot')}, from {min(ratios):.3g} to {max(ratios):.3g}",
            soft_wrap=True,
        )
    return status


def changes_table(changes: Sequence[SceneChange]) -> Table:
    """Return a table with a row for each change.

    Failures come first, then changes by severity, and equally severe changes by error.
    """
    order = [*CHANGES]
    rows = []
    for one in sorted(
        changes, key=lambda one: (not one.failed, order.index(one.change), -(one.head_error or 0.0))
    ):
        # Only the first part, the largest change; the report and the summary show every part.
        said = one.summary if len(changes) == 1 else one.summary.partition("; ")[0]
        label = (escape(one.label),) if one.label else ()
        rows.append((escape(one.scene), *label, coloured(one), error_text(one), escape(said)))
    engine = ("engine",) if any(one.label for one in changes) else ()
    heads = ("scene", *engine, "change", "error", "what changed")
    return table_of(heads, rows, whole=("scene",))
