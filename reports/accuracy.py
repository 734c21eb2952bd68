"""Texts for the accuracy of a case, the same in every table and picture."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from statistics import median
from typing import Final

from ghostball.reports import style
from ghostball.reports.words import many
from ghostball.validation.checks.verdict import Verdict, verdict_of
from ghostball.validation.results.records import (
    INDEPENDENT,
    Accuracy,
    AccuracyKind,
    CaseRecord,
    Check,
)
from ghostball.validation.results.store import Results


@dataclass(frozen=True)
class ClassLook:
    """Appearance of an accuracy class.

    `short`: heading of its column.
    `slug`: name of its colours on the page.
    `terminal`: colour in terminals.
    """

    short: str
    meaning: str
    slug: str
    terminal: str


CLASSES: Final[Mapping[AccuracyKind, ClassLook]] = {
    "exact": ClassLook("exact", "error no larger than rounding", "exact", "green"),
    "nanometres": ClassLook("nm", "position error below 1 µm", "nm", "cyan"),
    "micrometres": ClassLook("µm", "below 1 mm", "um", "blue"),
    "millimetres": ClassLook("mm", "below 1 cm", "mm", "yellow"),
    "centimetres": ClassLook("cm", "1 cm or more", "cm", "dark_orange3"),
    "another shot": ClassLook(
        "wrong collisions",
        "collisions that differ from the reference; in brackets: the number of right collisions "
        "before the first wrong collision, and the number in the reference",
        "other",
        "red",
    ),
    "broken": ClassLook(
        "unphysical",
        "energy gain, balls that pass through each other, velocities that jump "
        "without a contact, NaN or infinity; or the run did not finish",
        "broken",
        "bold magenta",
    ),
}
"""The classes, the best first."""

CLASSES_KEY: Final = "; ".join(f"{look.short}: {look.meaning}" for look in CLASSES.values())
"""The meanings of the classes, in one line."""

MARKS: Final = {Verdict.PASS: "✓", Verdict.FAIL: "✗", Verdict.LIMITS_HOLD: "≈"}
"""Marks beside a class, by verdict."""

MEANINGS: Final = {
    Verdict.PASS: "passed: within its limits, which allow for the engine's time step",
    Verdict.FAIL: "failed a limit",
    Verdict.LIMITS_HOLD: "passed, but no limit judges the final positions",
}
"""The meaning of each mark."""

MARKS_KEY: Final = (
    "; ".join(f"{MARKS[one]} {meaning}" for one, meaning in MEANINGS.items())
    + "; no mark: no limit applies"
)
"""The meanings of the marks, in one line."""


UP_TO_ROUNDING: Final = "rounding"
"""Text for an error that is no larger than rounding; its size means nothing."""

LEAST_TIME: Final = 1e-12
"""Below this, the time error of an exact case is shown as rounding [s]."""

LARGE: Final = ("millimetres", "centimetres")
"""Classes with large errors: if such a case passes, the limit that allows the error is shown."""


def length_text(case: CaseRecord | None, error: float | None) -> str:
    """Return an error of a case's final positions, or an overlap [m], as tables show it."""
    if error is not None and case is not None and case.is_exact:
        return UP_TO_ROUNDING
    return style.format_length(error)


def time_text(case: CaseRecord | None, error: float | None) -> str:
    """Return an error of a case's rest time [s] as tables show it."""
    if error is not None and case is not None and case.is_exact and error < LEAST_TIME:
        return UP_TO_ROUNDING
    return style.format_time(error)


def allowing_check(case: CaseRecord | None) -> Check | None:
    """Return the check with the tightest limit on the rest error of a case that passed.

    None if the case didn't pass, if its error isn't large, or if the rest error has no limit.
    """
    found = None if case is None else case.accuracy
    if case is None or found is None or found.kind not in LARGE:
        return None
    if verdict_of(case) is not Verdict.PASS:
        return None
    limits = [
        check
        for check in case.checks
        if check.metric == "rest_error_max" and check.limit_kind == "at_most" and check.passed
    ]
    return min(limits, key=lambda check: check.limit, default=None)


def allowed_text(case: CaseRecord | None) -> str:
    """Return the limit that permits a large error; "" if there is none.

    For example "within the limit of 9.66 mm".
    """
    check = allowing_check(case)
    return "" if check is None else f"within the limit of {style.format_length(check.limit)}"


def size_of(found: Accuracy | None) -> float | None:
    """Return the sorting key of a column of cases: class, then error; None without a class."""
    if found is None:
        return None
    error = found.error or 0.0
    return list(CLASSES).index(found.kind) + error / (1.0 + error)


def accuracy_text(case: CaseRecord | None) -> str:
    """Return the accuracy of a case for a cell: "exact", "3.67 mm", "wrong at 1 s (3 of 5 right)".

    "" if the case didn't run or its engine doesn't support the scene.
    """
    if case is None:
        return ""
    if case.outcome == "failed":
        return "did not finish"
    if case.outcome != "ran":
        return ""
    found = case.accuracy
    if found is None:
        if case.is_own_measure:
            return _own_text(case)
        return "no reference result" if case.truth is None else "past the horizon"
    if found.kind == "broken":
        return f"unphysical: {_broken_text(found)}"
    if found.kind == "another shot":
        since = "" if found.at is None else f" at {style.format_time(found.at)}"
        return f"wrong{since} ({_agree_text(found)})"
    shown = "exact" if found.kind == "exact" else style.format_length(found.error)
    return shown if found.at is None else f"{shown} at {style.format_time(found.at)}"


def meaning_text(case: CaseRecord | None) -> str:
    """Return the accuracy of a case in one sentence, without a full stop."""
    found = None if case is None else case.accuracy
    if case is None or found is None:
        return ""
    whose = "" if case.truth in INDEPENDENT else " (Ghostball's own result, which is not certified)"
    if found.kind == "broken":
        return f"unphysical: {_broken_text(found)}"
    if found.kind == "another shot":
        since = "" if found.at is None else f" from t = {style.format_time(found.at)} on"
        return f"wrong collisions{since}: {_agree_text(found)}, compared with the reference{whose}"
    error = style.format_length(found.error)
    off = f"the largest position error of a ball is {error}, compared with the reference{whose}"
    if found.kind == "exact":
        off = f"no position error larger than rounding, compared with the reference{whose}"
    if found.at is not None:
        off += (
            f", at t = {style.format_time(found.at)}: after that, rounding alone changes the "
            "collisions"
        )
    if (check := allowing_check(case)) is not None:
        off += f"; {allowed_text(case)}: {check.reason.rstrip('.')}"
    return f"{found.kind}: {off}"


def cell_text(case: CaseRecord | None) -> str:
    """Return the cell of a case in a table of engines and scenes: accuracy and mark."""
    verdict = verdict_of(case)
    if verdict is Verdict.MISSING:
        return ""
    if verdict in (Verdict.NOT_REPRESENTABLE, Verdict.UNAVAILABLE):
        return verdict.symbol
    return f"{accuracy_text(case)} {MARKS.get(verdict, '')}".strip()


@dataclass(frozen=True)
class Tally:
    """The results of one engine over all scenes of a run.

    `counts`: number of scenes in each accuracy class that occurs, the best class first.
    `expected`, `worse`: numbers of scenes that passed and that failed.
    `unable`, `crashed`: numbers of unsupported scenes and of scenes that did not finish.
    `compared_with`: number of scenes without a reference result, in which the other engines are
        compared with this engine.
    `typical` [m]: median error over the scenes with the reference collisions.
    `is_typical_exact`: whether the median error is no larger than rounding.
    `seconds`: median run time.
    """

    label: str
    counts: Mapping[AccuracyKind, int]
    expected: int
    worse: int
    unable: int
    crashed: int
    compared_with: int
    typical: float | None
    seconds: float | None
    is_typical_exact: bool = False

    @property
    def played(self) -> int:
        """Number of scenes with an accuracy class."""
        return sum(self.counts.values())

    @property
    def typical_text(self) -> str:
        """The median error as text for tables."""
        return median_text(self.typical, is_exact=self.is_typical_exact)

    @property
    def rank(self) -> float | None:
        """The mean of the classes, 0 for the best class; None if no scene has a class."""
        places = {kind: place for place, kind in enumerate(CLASSES)}
        total = sum(places[kind] * count for kind, count in self.counts.items())
        return total / self.played if self.played else None


def tally(results: Results, label: str) -> Tally:
    """Return the results of an engine over all scenes."""
    cases = [case for case in results.cases if case.label == label]
    verdicts = [verdict_of(case) for case in cases]
    found = [case.accuracy for case in cases if case.accuracy is not None]
    kinds = Counter(one.kind for one in found)
    typical, is_typical_exact = median_error((one.error, one.kind) for one in found)
    times = [case.wall_time for case in cases if case.wall_time is not None]
    return Tally(
        label,
        {kind: kinds[kind] for kind in CLASSES if kinds[kind]},
        verdicts.count(Verdict.PASS),
        verdicts.count(Verdict.FAIL),
        verdicts.count(Verdict.NOT_REPRESENTABLE) + verdicts.count(Verdict.UNAVAILABLE),
        sum(case.outcome == "failed" for case in cases),
        sum(case.accuracy is None and case.is_own_measure for case in cases),
        typical,
        median(times) if times else None,
        is_typical_exact,
    )


def median_error(
    found: Iterable[tuple[float | None, AccuracyKind]],
) -> tuple[float | None, bool]:
    """Return the median of errors [m], and True if the median is no larger than rounding.

    `found`: the error of each case, if it is known, and the accuracy class of the case.

    Without any known error the median is None.
    """
    errors = sorted((error, kind) for error, kind in found if error is not None)
    if not errors:
        return None, False
    middle = errors[(len(errors) - 1) // 2 : len(errors) // 2 + 1]
    return median(error for error, _ in errors), all(kind == "exact" for _, kind in middle)


def median_text(error: float | None, *, is_exact: bool) -> str:
    """Return a median error [m], from `median_error`, as text for tables."""
    return UP_TO_ROUNDING if is_exact else style.format_length(error)


def kinds_of(cases: Iterable[CaseRecord]) -> tuple[AccuracyKind, ...]:
    """Return the accuracy classes that occur among cases, the best first."""
    present = {case.accuracy.kind for case in cases if case.accuracy is not None}
    return tuple(kind for kind in CLASSES if kind in present)


def _own_text(case: CaseRecord) -> str:
    until = case.metrics.get("graded_until")
    if until is None:
        return "the reference"
    return f"certified to {style.format_time(float(until))}"


def _agree_text(found: Accuracy) -> str:
    more = ", then extra" if found.agree == found.of else ""
    return f"{found.agree} of {found.of} right{more}"


def _broken_text(found: Accuracy) -> str:
    if found.cause == "energy":
        made = found.amount or 0.0
        return f"energy +{100.0 * made:.2g} %" if made < 100.0 else "gains energy"
    if found.cause == "overlap":
        return f"balls overlap by {style.format_length(found.amount)}"
    if found.cause == "jump":
        return "velocities jump"
    return "stopped early" if found.cause == "stopped" else "NaN or infinity"


def wrong_text(cases: Iterable[CaseRecord]) -> str:
    """Return "wrong collisions in 2 cases, not judged"; "" if no case has any.

    Cases with unphysical motion are counted, too. A counted case may pass all its limits, because
    limits allow for the time step. The text has ", not judged" if all counted cases pass and no
    limit judges their final positions.
    """
    whats: Mapping[AccuracyKind, str] = {
        "another shot": "wrong collisions",
        "broken": "unphysical motion",
    }
    wrong = [
        (whats[case.accuracy.kind], verdict_of(case))
        for case in cases
        if case.accuracy is not None and case.accuracy.kind in whats
    ]
    counts = Counter(what for what, _ in wrong)
    said = ", ".join(f"{what} in {many(counts[what], 'case')}" for what in counts)
    unjudged = all(verdict in (Verdict.LIMITS_HOLD, Verdict.SHOWN) for _, verdict in wrong)
    return f"{said}, not judged" if said and unjudged else said
