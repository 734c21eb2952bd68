"""What the page says of one scene, in Markdown: collisions, numbers, remarks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ghostball.reports import style
from ghostball.reports.counted import counted_text
from ghostball.reports.markdown_parts import (
    metric_of,
    number_text,
    one_line,
    run_time_text,
    table_of,
)
from ghostball.reports.shots import rest_error_text, standing_text
from ghostball.validation.checks.verdict import (
    RestError,
    is_own_measure,
    rest_error_standing,
    verdict_of,
)
from ghostball.validation.results.store import CLOSED_FORM, INDEPENDENT, CaseRecord, Check

COMPARISONS = {"at_most": "at most", "at_least": "at least", "equals": "exactly"}


def collision_text(cases: Sequence[CaseRecord]) -> str:
    """Say how many collisions there are in truth, and who counts them."""
    truth = next((case for case in cases if case.truth_counts is not None), None)
    if truth is None or truth.truth_counts is None:
        return ""
    said: dict[bool, list[str]] = {True: [], False: []}
    for case in cases:
        if case.outcome != "ran" or is_own_measure(case):
            continue
        right = all(
            case.collision_counts.get(kind, 0) == count
            for kind, count in truth.truth_counts.items()
        )
        said[right].append(
            f"`{case.label}`" if right else f"`{case.label}` {_counts(case.collision_counts)}"
        )
    source = "in truth" if truth.truth in INDEPENDENT else "by our engine (not independent)"
    parts = [f"Collisions {source}: **{_counts(truth.truth_counts)}**"]
    # A proof counts also what nobody could predict: to differ there is not to be wrong.
    closed = truth.truth == CLOSED_FORM
    agree, differ = ("Right", "Wrong") if closed else ("The same", "Different")
    parts += [f"{agree}: {', '.join(said[True])}"] if said[True] else []
    parts += [f"{differ}: {', '.join(said[False])}"] if said[False] else []
    return ". ".join(parts) + "."


def _counts(counts: Mapping[str, int]) -> str:
    kinds = [f"{count} {kind}" for kind, count in counts.items() if count]
    if len(kinds) < 2:
        return kinds[0] if kinds else "0"
    return f"{sum(counts.values())} ({', '.join(kinds)})"


def number_table(cases: Sequence[CaseRecord]) -> str:
    """Return what was measured of each engine."""
    # Where a scene ends at its `t_max` nothing rests.
    end = "end" if any(case.status == "t-max" for case in cases) else "rest"
    header = [
        "engine",
        "verdict",
        f"{end} error, max (in brackets: not judged)",
        "rms",
        f"{end} time [s]",
        "its error",
        "ball-ball",
        "ball-cushion",
        "collisions in order",
        "energy difference [1]",
        "deepest overlap",
        "run time",
    ]
    rows = []
    for case in cases:
        metrics = case.metrics
        own = is_own_measure(case)
        rows.append(
            [
                f"`{case.label}`",
                verdict_of(case).symbol,
                "the reference" if own else rest_error_text(case) or "–",
                standing_text(case, style.format_length(metric_of(case, "rest_error_rms"))),
                "–" if case.rest_time is None else f"{case.rest_time:.6g}",
                _rest_time_error_text(case),
                str(case.collision_counts.get("ball-ball", "–")),
                str(case.collision_counts.get("ball-cushion", "–")),
                "–" if metrics.get("matching_events") is None else f"{metrics['matching_events']}",
                "" if own else number_text(metric_of(case, "energy_difference_max")),
                style.format_length(metric_of(case, "overlap_max")),
                run_time_text(case),
            ]
        )
    return table_of(header, rows)


def _rest_time_error_text(case: CaseRecord) -> str:
    """Return the rest time's error; where the rest positions are past prediction, so is this."""
    if rest_error_standing(case) in (RestError.CHAOTIC, RestError.OWN):
        return rest_error_text(case)
    return style.format_time(metric_of(case, "rest_time_error"))


def remarks(cases: Sequence[CaseRecord]) -> str:
    """Return why engines did not run, what failed, what they approximate or count, as a list."""
    lines = []
    for case in cases:
        if case.outcome != "ran":
            lines.append(f"- `{case.label}` {verdict_of(case).words}: {one_line(case.reason)}")
        elif case.reason:
            lines.append(f"- `{case.label}` stopped early ({case.status}): {one_line(case.reason)}")
        if case.printed:
            lines.append(f"- `{case.label}` printed: {one_line(case.printed)}")
        lines += [failure_text(case, check) for check in case.checks if check.passed is False]
        if case.approximations:
            lines.append(
                f"- `{case.label}` approximates: {one_line('; '.join(case.approximations))}"
            )
        if counted := counted_text(case):
            lines.append(f"- `{case.label}` counted {counted}")
    return "\n".join(lines)


def failure_text(case: CaseRecord, check: Check) -> str:
    """Return a check that failed as an item of a list: what was found, the limit and its reason."""
    note = "" if check.value is None else check.note  # else the sentence has it
    why = "; ".join(one_line(text) for text in (check.reason, note) if text)
    return f"- **`{case.label}` fails**: {one_line(check.sentence)}" + f" ({why})" * bool(why)
