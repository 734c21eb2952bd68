"""Decide the verdict on a case, and whether its rest error is judged, shown or left out.

A case may pass every stated limit although none of them judges the final positions: energy is
conserved, but the balls rest in the wrong place. Such a case is `LIMITS_HOLD`, never `PASS`.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Collection

from ghostball.validation.checks.metrics import METRICS
from ghostball.validation.results.records import (
    ACCURACY_KINDS,
    COMPLETE_STATUSES,
    INDEPENDENT,
    CaseRecord,
    Check,
)


class Verdict(enum.Enum):
    """The verdict on one engine in one scene: its sign, and its words in reports."""

    PASS = ("✓", "passed")
    LIMITS_HOLD = ("≈", "passed, final positions not judged")
    FAIL = ("✗", "failed")
    REFERENCE = ("=", "reference for the other engines")
    SHOWN = ("○", "not judged: no limit applies")
    NOT_REPRESENTABLE = ("–", "unsupported")
    UNAVAILABLE = ("–", "unavailable")
    CRASHED = ("!", "did not finish")
    MISSING = ("", "not run")

    @property
    def symbol(self) -> str:
        """The sign in plain text, so that colour is never the only mark."""
        return self.value[0]

    @property
    def words(self) -> str:
        """The verdict in words."""
        return self.value[1]


FAILING = (Verdict.FAIL, Verdict.CRASHED)
"""Verdicts that make a run fail."""

NOTHING_JUDGED = "nothing was judged: no limit applies"
"""Message for a run without any verdict; commands then have exit status 4."""

UNJUDGED = (
    "had its final positions judged: declare a time step `dt` or, in a class or a run, a "
    "`resolution`; or set limits on `rest_error_max` of at most a ball's radius"
)
"""Message for engines that state too little about how exact they are."""

NO_REFERENCE = (
    "had its final positions judged, because no scene has an independent reference: choose other "
    "scenes; or set limits on `rest_error_max` of at most a ball's radius"
)
"""Message for engines whose scenes all lack an independent reference."""


class RestError(enum.Enum):
    """Whether the rest error of a case is judged, which decides how it is shown."""

    JUDGED = "a limit judges it"
    UNJUDGED = "not judged: shown in brackets"
    CHAOTIC = "no error: after the engine's horizon"
    OWN = "Ghostball's engine compared with itself"
    NONE = "no rest error was measured"


def verdict_of(case: CaseRecord | None) -> Verdict:
    """Return the verdict on a case; None is a case that the run never reached."""
    if case is None:
        return Verdict.MISSING
    if case.outcome != "ran":
        return {
            "not-representable": Verdict.NOT_REPRESENTABLE,
            "unavailable": Verdict.UNAVAILABLE,
            "failed": Verdict.CRASHED,
        }[case.outcome]
    if is_unfinished(case):
        return Verdict.CRASHED
    if case.passed is False:
        return Verdict.FAIL
    if case.is_own_measure:
        return Verdict.REFERENCE
    if case.passed is None:
        return Verdict.SHOWN
    return Verdict.PASS if is_outcome_judged(case) else Verdict.LIMITS_HOLD


def is_unfinished(case: CaseRecord) -> bool:
    """Return True if an engine that supports the scene failed or stopped early."""
    if case.outcome == "ran":
        return case.status not in COMPLETE_STATUSES
    return case.outcome == "failed"


def unfinished_text(case: CaseRecord) -> str:
    """Return why a case didn't finish; "" if it finished, or never started."""
    if not is_unfinished(case):
        return ""
    if case.outcome == "failed":
        return case.reason
    return f"stopped early: {case.status}" + (f": {case.reason}" if case.reason else "")


def is_nothing_judged(cases: Collection[CaseRecord]) -> bool:
    """Return True if nothing failed, but no limit judged anything: this is not a pass."""
    judged = (check for case in cases for check in case.checks if check.passed is not None)
    return next(judged, None) is None and not any(map(is_unfinished, cases))


def unjudged_engines(cases: Collection[CaseRecord]) -> tuple[str, ...]:
    """Return the engines that state too little for any of their final positions to be judged.

    They state no resolution, or a time step so long that balls may end anywhere, and no limit of a
    scene or of the user applies to their final positions. Engines excused by name, or run with
    selected metrics, are not included, because that was the user's choice. Nor are engines with no
    shot that is predictable to its end.
    """
    ran = [case for case in cases if case.outcome == "ran" and not case.varied_from]
    chosen = {case.label for case in ran if case.excused or case.left_out}
    judged = {case.label for case in ran if is_outcome_judged(case)}
    free = {
        case.label
        for case in ran
        if case.unstated or (case.horizon is None and not case.is_own_measure)
    }
    labels = dict.fromkeys(case.label for case in ran)
    return tuple(label for label in labels if label in free - chosen - judged)


def few_ends_judged(cases: Collection[CaseRecord]) -> str:
    """Return in how many scenes the end of the shot was judged; "" if in all scenes.

    `cases`: of one engine. One judged scene is enough for a pass, so readers must know how
        many are judged. Returns "" for an engine that is excused, or was run with selected metrics.
    """
    ran = [case for case in cases if case.outcome == "ran" and not case.varied_from]
    judged = sum(case.is_own_measure or is_outcome_judged(case) for case in ran)
    if judged == len(ran) or any(case.excused or case.left_out for case in ran):
        return ""
    return f"the final positions were judged in {judged} of {len(ran)} scenes"


def not_judged(cases: Collection[CaseRecord]) -> str:
    """Return why a run without failures isn't a pass; "" if it is a pass."""
    if is_nothing_judged(cases):
        return NOTHING_JUDGED
    if engines := unjudged_engines(cases):
        ran = [one for one in cases if one.outcome == "ran" and one.label in engines]
        known = any(one.truth in INDEPENDENT for one in ran)
        return f"no case of {', '.join(engines)} {UNJUDGED if known else NO_REFERENCE}"
    return ""


def rest_verdict_of(case: CaseRecord) -> Verdict:
    """Return the verdict of the checks on the rest error alone; SHOWN if there is none.

    A case may pass by its collision counts while its rest error has no limit: a figure of rest
    errors must not show this error as passed.
    """
    verdicts = [
        check.passed
        for check in case.checks
        if check.metric.startswith("rest_error") and _judges_outcome(check, case)
    ]
    if not verdicts:
        return Verdict.SHOWN
    return Verdict.PASS if all(verdicts) else Verdict.FAIL


def rest_error_standing(case: CaseRecord | None) -> RestError:
    """Return whether the rest error of a case is judged."""
    if case is None or case.outcome != "ran":
        return RestError.NONE
    judged = rest_verdict_of(case) is not Verdict.SHOWN
    if case.horizon is not None and not judged and not case.is_own_measure:
        return RestError.CHAOTIC
    if case.metrics.get("rest_error_max") is None:
        return RestError.NONE
    if case.is_own_measure:
        return RestError.OWN
    return RestError.JUDGED if judged else RestError.UNJUDGED


def is_outcome_judged(case: CaseRecord) -> bool:
    """Return True if some check, passed or not, judges the outcome.

    False if a limit allows a rest error of more than the smallest radius, and no tighter limit
    applies: then correct collision counts aren't enough.
    """
    ends_judged = rest_verdict_of(case) is not Verdict.SHOWN
    if not ends_judged and any(_is_too_wide(check, case) for check in case.checks):
        return False
    return any(_judges_outcome(check, case) for check in case.checks)


def _is_too_wide(check: Check, case: CaseRecord) -> bool:
    """Return True if a check allows a rest error of more than the smallest radius."""
    if not check.metric.startswith("rest_error") or check.unit != "m":
        return False
    radii = [ball["radius"] for ball in case.definition.get("balls", ())]
    return check.limit_kind != "at_least" and check.limit > min(radii, default=math.inf)


def _judges_outcome(check: Check, case: CaseRecord) -> bool:
    """Return True if a check, passed or not, judges the outcome.

    Four kinds of checks don't: a lower limit, because "the first 25 collisions agree" says nothing
    about the end; a quality factor, if it isn't that of the end of the shot; a limit on the
    accuracy class that allows centimetres or more; and a limit that is wider than a ball.
    """
    if check.passed is None or check.limit_kind == "at_least" or _is_too_wide(check, case):
        return False
    if check.metric == "quality_factor":
        return case.horizon is None and case.truth in INDEPENDENT
    if check.metric == "accuracy":
        return check.limit < ACCURACY_KINDS.index("centimetres")
    metric = METRICS.get(check.metric)
    return metric is not None and metric.judges != ""
