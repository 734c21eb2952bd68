"""Measured values, counters and remarks of one scene, for each engine."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ghostball.reports.accuracy import length_text, time_text
from ghostball.reports.shared_tables import COMPARISON_HEADS, comparison_cells
from ghostball.reports.shots import rest_error_text, standing_text
from ghostball.reports.words import metric_of, run_time_text
from ghostball.validation.checks.verdict import RestError, rest_error_standing, verdict_of
from ghostball.validation.results.store import CaseRecord, Check, Results

COMPARISONS = {"at_most": "at most", "at_least": "at least", "equals": "exactly"}


COUNTED = {
    "joint_impacts": "simultaneous impacts, resolved together",
    "unsolved_joint_impacts": "simultaneous impacts left unsolved",
    "contact_steps": "contact steps (balls in resting contact)",
    "contact_pieces": "further trajectory segments within contact steps",
    "unsolved_contact_steps": "contact steps left unsolved",
    "pulls": "overlapping balls pulled apart",
    "put_backs": "balls moved back inside a cushion",
    "coincident_pairs": "balls at the same position",
    "overlaps": "overlaps that the search for collisions ignored",
}
"""Counters of `Result.work` that stand for an approximation or a repair, in words."""

UNSOLVED = ("unsolved_joint_impacts", "unsolved_contact_steps")

SCENES_SHOWN = 8
"""Largest number of scenes listed in a cell of a table."""


@dataclass(frozen=True)
class Remark:
    """A remark about one case: a text, or a failed check."""

    case: CaseRecord
    text: str
    failed: Check | None = None


def number_heads(cases: Sequence[CaseRecord]) -> list[str]:
    """Return the headings of the table of numbers."""
    # In a scene that ends at `t_max`, balls still move.
    end = "end" if any(case.status == "t-max" for case in cases) else "rest"
    own = (f"{end} error, rms", f"{end} time [s]", "time error", "largest overlap", "run time")
    return [*COMPARISON_HEADS, *own]


def number_row(case: CaseRecord) -> list[str]:
    """Return the measured values of one case, in the order of `number_heads`."""
    time_error = time_text(case, metric_of(case, "rest_time_error"))
    if rest_error_standing(case) in (RestError.CHAOTIC, RestError.OWN):
        time_error = rest_error_text(case)  # the same words as for the rest positions
    return [
        *(comparison_cells(case) or ["–"] * len(COMPARISON_HEADS)),
        standing_text(case, length_text(case, metric_of(case, "rest_error_rms"))) or "–",
        "–" if case.rest_time is None else f"{case.rest_time:.6g}",
        time_error,
        length_text(case, metric_of(case, "overlap_max")),
        run_time_text(case, dated=case.reused),
    ]


def remarks(cases: Sequence[CaseRecord]) -> Iterator[Remark]:
    """Yield remarks: why a case did not run, failed checks, approximations and counters."""
    for case in cases:
        if case.outcome != "ran":
            yield Remark(case, f"{verdict_of(case).words}: {case.reason}")
        elif case.reason:
            yield Remark(case, f"stopped early ({case.status}): {case.reason}")
        if case.printed:
            yield Remark(case, f"printed: {case.printed}")
        yield from (Remark(case, "", check) for check in case.broken)
        if case.approximations:
            yield Remark(case, f"approximates: {'; '.join(case.approximations)}")
        if counted := counted_text(case):
            yield Remark(case, f"counted {counted}")


def counted_text(case: CaseRecord) -> str:
    """Return the counted approximations of a case in words; "" if there are none."""
    found = ((case.work.get(name), words) for name, words in COUNTED.items())
    return ", ".join(f"{count} {words}" for count, words in found if count)


def work_text(case: CaseRecord) -> str:
    """Return the name and value of every counter in `Result.work`."""
    return ", ".join(f"{name.replace('_', ' ')} {count}" for name, count in case.work.items())


def counted_rows(results: Results) -> Iterator[tuple[str, str, int, list[tuple[str, int]], int]]:
    """Yield the engine, words, total and scenes of each counter, for the page's table.

    At most `SCENES_SHOWN` scenes are listed, those with the largest counts; the last value is the
    number of further scenes.
    """
    for label in results.labels:
        cases = [case for case in results.cases if case.label == label]
        for name, words in COUNTED.items():
            found = {case.scene: case.work[name] for case in cases if case.work.get(name)}
            if not found:
                continue
            most = sorted(found, key=lambda scene: (-found[scene], scene))
            shown = [(scene, found[scene]) for scene in most[:SCENES_SHOWN]]
            yield label, words, sum(found.values()), shown, len(most) - len(shown)


def unsolved(results: Results) -> int:
    """Return the number of simultaneous impacts and contact steps left unsolved in all cases."""
    return sum(case.work.get(name, 0) for case in results.cases for name in UNSOLVED)
