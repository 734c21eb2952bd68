"""What `ghostball diff` does: compare two runs, or two engines of one run."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from rich.markup import escape

from ghostball.cli.shared.config import load_config
from ghostball.cli.shared.options import Plain
from ghostball.cli.shared.tables import table_of
from ghostball.cli.shared.terminal import stdout
from ghostball.model import GhostballError
from ghostball.reports.accuracy import cell_text
from ghostball.reports.outcome import coloured
from ghostball.reports.words import many
from ghostball.validation.baselines import Played, SceneChange, compare
from ghostball.validation.baselines.rounding import allowance
from ghostball.validation.checks.verdict import FAILING, verdict_of
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.results.records import ACCURACY_KINDS
from ghostball.validation.results.store import CaseRecord, Results, has_results


@dataclass(frozen=True)
class Difference:
    """A scene of both runs, and how it differs; a run may have no case of it."""

    base: CaseRecord | None
    head: CaseRecord | None
    change: SceneChange | None

    @property
    def verdicts(self) -> tuple[str, str]:
        """What limits say of both, in words."""
        base, head = (
            "not there" if case is None else verdict_of(case).words
            for case in (self.base, self.head)
        )
        return base, head

    @property
    def differs(self) -> bool:
        """Whether anything does: the result, a metric, a verdict, or that it is there."""
        change = self.change
        alike = change is not None and change.change == "unchanged" and not change.metrics
        return not alike or self.verdicts[0] != self.verdicts[1]

    @property
    def fails(self) -> bool:
        """Whether the head drops an accuracy class, or fails where the base does not."""
        base, head = self.base, self.head
        if base is None or head is None or base.definition != head.definition:
            return False
        if verdict_of(head) in FAILING and verdict_of(base) not in FAILING:
            return True
        classes = [None if one.accuracy is None else one.accuracy.kind for one in (base, head)]
        if None in classes:
            return False
        before, after = (ACCURACY_KINDS.index(str(one)) for one in classes)
        return after > before

    @property
    def plain(self) -> dict[str, Any]:
        """All of it as plain values."""
        change = self.change
        return {
            "scene": next(one.scene for one in (self.base, self.head) if one is not None),
            "base": _side(self.base),
            "head": _side(self.head),
            "change": None if change is None else change.change,
            "summary": "" if change is None else change.summary,
            "differs": self.differs,
            "fails": self.fails,
            "metrics": [] if change is None else [one.model_dump() for one in change.metrics],
        }


def run(first: str, second: str, out: Path | None, form: Plain) -> ExitStatus:
    """Compare two results folders, or two engines of one; print what differs."""
    base, head, labels = _sides(first, second, load_config().out if out is None else out)
    found = differences(base, head, labels)
    ratios = [
        one.head.wall_time / one.base.wall_time
        for one in found
        if one.base is not None
        and one.head is not None
        and one.base.wall_time
        and one.head.wall_time
    ]
    return show(first, second, found, ratios, form)


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


def differences(base: Results, head: Results, labels: Mapping[str, str]) -> list[Difference]:
    """Compare two runs scene by scene: in the order of the base, then what only the head has.

    `labels`: which engine of the head each engine of the base is compared with, by label; {}
        compares each with itself.
    """
    chosen = [case for case in base.cases if not labels or case.label in labels]
    after = {
        (case.scene, case.label): case
        for case in head.cases
        if not labels or case.label in labels.values()
    }
    found = []
    for case in chosen:
        other = after.pop((case.scene, labels.get(case.label, case.label)), None)
        change = None if other is None else _change(base, case, head, other)
        found.append(Difference(case, other, change))
    return found + [Difference(None, case, None) for case in after.values()]


def _change(base: Results, one: CaseRecord, head: Results, two: CaseRecord) -> SceneChange:
    before, after = Played.stored(base, one), Played.stored(head, two)
    if one.label != two.label:
        return compare(before, after)
    explained = lambda: allowance(  # noqa: E731
        two.load_scene(), two.label, after.log().events, two.rest_time or 0.0
    )
    return compare(before, after, explained)


def show(
    first: str, second: str, found: Sequence[Difference], ratios: Sequence[float], form: Plain
) -> ExitStatus:
    """Print what differs, and return the exit status.

    `ratios`: run times of the second over those of the first.
    """
    if not found:
        raise GhostballError(f"{first} and {second} have no scene, so there is nothing to compare")
    failed = any(one.fails for one in found)
    status = ExitStatus.CHECK_FAILED if failed else ExitStatus.PASSED
    if form is Plain.JSON:
        ratio = median(ratios) if ratios else None
        sides = {"base": first, "head": second, "run_time_ratio": ratio}
        print(json.dumps(sides | {"cases": [one.plain for one in found]}))
        return status
    console, moved = stdout(), [one for one in found if one.differs]
    moved.sort(key=lambda one: (not one.fails, one.change is None))
    if moved:
        heads = ("scene", "engine", "how right", "change", "what differs")
        console.print(table_of(heads, map(_row, moved)))
    counts = Counter(one.change.change for one in moved if one.change is not None)
    parts = [f"{len(found) - len(moved)} of {many(len(found), 'case')} alike"]
    parts += [f"{count} {answer}" for answer, count in counts.items()]
    fail = sum(one.fails for one in found)
    parts += [f"[bold red]{fail} fail: a class lower, or a limit[/]"] * bool(fail)
    console.print(f"{', '.join(parts)}: {escape(first)} -> {escape(second)}", soft_wrap=True)
    if ratios:
        spread = f"{min(ratios):.2f} to {max(ratios):.2f}"
        console.print(
            f"run time, {escape(second)} over {escape(first)}: {median(ratios):.2f} in the median "
            f"of {many(len(ratios), 'shot')}, {spread}",
            soft_wrap=True,
        )
    return status


def _row(one: Difference) -> tuple[str, ...]:
    cases = [case for case in (one.base, one.head) if case is not None]
    base, head = (
        one.verdicts[side] if case is None else cell_text(case)
        for side, case in enumerate((one.base, one.head))
    )
    right = escape(head if base == head else f"{base} -> {head}")
    labels = " -> ".join(dict.fromkeys(case.label for case in cases))
    right = f"[bold red]{right}[/]" if one.fails else right
    if one.change is None:
        return cases[0].scene, escape(labels), right, "", ""
    what = [one.change.summary] if one.change.change != "unchanged" else []
    what += [f"{len(one.change.metrics)} metrics"] * bool(one.change.metrics)
    return cases[0].scene, escape(labels), right, coloured(one.change), escape("; ".join(what))


def _side(case: CaseRecord | None) -> dict[str, Any] | None:
    if case is None:
        return None
    kind = None if case.accuracy is None else case.accuracy.kind
    return {"engine": case.label, "class": kind, "verdict": verdict_of(case).words}
