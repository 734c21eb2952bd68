"""What `ghostball diff` does: compare two runs, or two engines of one run."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median

from rich.markup import escape
from rich.table import Table

from ghostball.cli.shared.config import load_config
from ghostball.cli.shared.options import Plain
from ghostball.cli.shared.tables import table_of
from ghostball.cli.shared.terminal import stdout
from ghostball.model import GhostballError
from ghostball.reports.outcome import CHANGES, coloured
from ghostball.reports.shift import error_text
from ghostball.reports.words import many
from ghostball.validation.baselines import Played, SceneChange, compare
from ghostball.validation.baselines.rounding import allowance
from ghostball.validation.checks.verdict import FAILING, unfinished_text, verdict_of
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.results.records import ACCURACY_KINDS
from ghostball.validation.results.store import CaseRecord, Results, has_results

Pair = tuple[CaseRecord | None, CaseRecord | None]
"""A scene's case of the base and of the head; None where a run has none."""


def run(first: str, second: str, out: Path | None, form: Plain) -> ExitStatus:
    """Compare two results folders, or two engines of one; print what differs."""
    base, head, labels = _sides(first, second, load_config().out if out is None else out)
    found = paired(base, head, labels)
    times = [(one.wall_time, two.wall_time) for one, two in found if one and two]
    ratios = [after / before for before, after in times if before and after]
    return show(first, second, changes_of(base, head, found), ratios, form)


def _sides(first: str, second: str, folder: Path) -> tuple[Results, Results, Mapping[str, str]]:
    """Return both runs, and which engine is compared with which, by label; {} for all."""
    folders = [Path(one) for one in (first, second)]
    if all(map(has_results, folders)):
        base, head = map(Results.open, folders)
        return base, head, {}
    for one, path in zip((first, second), folders, strict=True):
        if path.is_dir() or has_results(path):
            Results.open(path)  # says what is wrong with it, if anything is
            other = second if one == first else first
            raise GhostballError(
                f"{other}: no results folder, as {one} is. Give two of them, or two engines"
            )
    results = Results.open(folder)
    for one in (first, second):
        if one not in results.labels:
            raise GhostballError(
                f"{one}: neither a results folder nor an engine of {folder}, which has "
                f"{', '.join(results.labels)}. Another folder is chosen by `--out`"
            )
    return results, results, {first: second}


def paired(base: Results, head: Results, labels: Mapping[str, str]) -> list[Pair]:
    """Return the cases of two runs in the order of the base; then what only the head has.

    `labels`: which engine of the head each engine of the base is compared with, by label; {}
        compares each with itself.
    """
    chosen = [case for case in base.cases if not labels or case.label in labels]
    after = {
        (case.scene, case.label): case
        for case in head.cases
        if not labels or case.label in labels.values()
    }
    pairs: list[Pair] = [
        (case, after.pop((case.scene, labels.get(case.label, case.label)), None)) for case in chosen
    ]
    return pairs + [(None, case) for case in after.values()]


def changes_of(base: Results, head: Results, pairs: Sequence[Pair]) -> list[SceneChange]:
    """Compare the cases of two runs.

    A change fails if the head drops an accuracy class, or fails where the base does not.
    """
    found = []
    for one, two in pairs:
        if one is None or two is None:
            case, where = (two, base) if one is None else (one, head)
            assert case is not None
            why = f"not there: {where.path} has no such case"
            change = SceneChange(
                scene=case.scene, title=case.title, change="not-comparable", summary=why
            )
            found.append(change.model_copy(update={"label": case.label}))
        else:
            found.append(_change(base, one, head, two))
    return found


def _change(base: Results, one: CaseRecord, head: Results, two: CaseRecord) -> SceneChange:
    before, after = Played.stored(base, one), Played.stored(head, two)
    if one.label == two.label:
        found = compare(
            before,
            after,
            lambda: allowance(
                two.load_scene(), two.label, after.log().events, two.rest_time or 0.0
            ),
        )
    else:
        found = compare(before, after)
    label = " -> ".join(dict.fromkeys([one.label, two.label]))
    if found.change == "not-comparable":
        return found.model_copy(update={"label": label})
    fails = verdict_of(two) in FAILING and verdict_of(one) not in FAILING
    broken = [check.sentence for check in two.checks if check.passed is False] if fails else []
    broken += [why] if fails and (why := unfinished_text(two)) else []
    kinds = [case.accuracy.kind for case in (one, two) if case.accuracy is not None]
    drops = len(kinds) == 2 and ACCURACY_KINDS.index(kinds[0]) < ACCURACY_KINDS.index(kinds[1])
    return found.model_copy(
        update={"label": label, "failed": fails or drops, "broken": tuple(broken)}
    )


def show(
    first: str, second: str, found: Sequence[SceneChange], ratios: Sequence[float], form: Plain
) -> ExitStatus:
    """Print what differs, and return the exit status.

    `ratios`: run times of the second over those of the first.
    """
    if not found:
        raise GhostballError(f"{first} and {second} have no scene, so there is nothing to compare")
    status = ExitStatus.CHECK_FAILED if any(one.failed for one in found) else ExitStatus.PASSED
    if form is Plain.JSON:
        ratio = median(ratios) if ratios else None
        cases = [json.loads(one.model_dump_json()) for one in found]  # null where it is not finite
        sides = {"base": first, "head": second, "run_time_ratio": ratio, "cases": cases}
        print(json.dumps(sides))
        return status
    console = stdout()
    moved = [one for one in found if one.moved or one.metrics or one.broken]
    if moved:
        console.print(changes_table(moved))
    counts = Counter(one.words for one in moved)
    parts = [f"{len(found) - len(moved)} of {many(len(found), 'case')} alike"]
    parts += [f"{count} {words}" for words, count in counts.items()]
    if fail := sum(one.failed for one in found):
        parts.append(f"[bold red]{fail} fail: a class lower, or a limit[/]")
    console.print(f"{', '.join(parts)}: {escape(first)} -> {escape(second)}", soft_wrap=True)
    if ratios:
        console.print(
            f"run time, {escape(second)} over {escape(first)}: {median(ratios):.3g} in the median "
            f"of {many(len(ratios), 'shot')}, {min(ratios):.3g} to {max(ratios):.3g}",
            soft_wrap=True,
        )
    return status


def changes_table(changes: Sequence[SceneChange]) -> Table:
    """Return a row for each change: what fails first, then the gravest, then the largest error."""
    order = [*CHANGES]
    rows = []
    for one in sorted(
        changes,
        key=lambda one: (not one.failed, order.index(one.change), -(one.head_error or 0.0)),
    ):
        # The first says what moved most; page and summary have all.
        said = one.summary if len(changes) == 1 else one.summary.partition("; ")[0]
        label = (escape(one.label),) if one.label else ()
        rows.append((escape(one.scene), *label, coloured(one), error_text(one), escape(said)))
    engine = ("engine",) if any(one.label for one in changes) else ()
    heads = ("scene", *engine, "change", "error", "what changed")
    return table_of(heads, rows, whole=("scene",))
