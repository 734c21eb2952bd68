"""The verdict on a whole run: on its limits, and on its comparison with baselines.

A run fails if one of the two fails. All reports use the verdicts of this module.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

from ghostball.reference_adapters.registry import OURS
from ghostball.reports.accuracy import wrong_text
from ghostball.reports.words import many
from ghostball.validation.baselines.regression import (
    LENIENT,
    UNCOMPARED,
    Change,
    Regression,
    SceneChange,
)
from ghostball.validation.checks.verdict import (
    Verdict,
    is_unfinished,
    not_judged,
    unfinished_text,
    verdict_of,
)
from ghostball.validation.results.store import CaseRecord, Check, Results
from ghostball.validation.scenes import commands

CHANGES: Final[dict[Change, tuple[str, str]]] = {
    "not-deterministic": ("✗", "not deterministic: repeated runs differ"),
    "wrong collisions": ("✗", "wrong collisions"),
    "worse": ("✗", "worse: farther from the reference result"),
    "changed": ("△", "changed, neither better nor worse"),
    "better": ("▲", "better: closer to the reference result"),
    "rounding": ("≈", "changed by rounding only"),
    "not-comparable": ("–", "not comparable"),
    "no-baseline": ("?", "no baseline"),
    "unchanged": ("=", "unchanged, bit-identical"),
}
"""Changes of a scene, the most severe first: sign and meaning."""

_COLOURS = {"✗": "bold red", "△": "bold red", "▲": "cyan", "=": "green"}

_SIGNS = ("✗", "!", "?", "○", "✓")
"""Signs of verdicts, the worst first."""

_KINDS = {"✗": "fail", "!": "fail", "?": "holds", "○": "holds", "✓": "pass"}


PASSED = "Passed"

_BESIDES = "; "


@dataclass(frozen=True)
class Answer:
    """The verdict on the limits, or on the comparison: a sign (✓ is a pass), a word, a sentence.

    `besides`: a warning beside a pass, such as wrong collisions that no limit judges; "" if none.
    """

    sign: str
    word: str
    why: str
    besides: str = ""


@dataclass(frozen=True)
class Overall:
    """The verdict on a whole run: sign, word, colour class, and reason."""

    sign: str
    word: str
    kind: str
    why: str

    @property
    def short(self) -> str:
        """The word without the warning."""
        return self.word.partition(_BESIDES)[0]


def overall(results: Results | None, *regressions: Regression | None) -> Overall:
    """Return the verdict on a whole run, with the worse sign and the words of both verdicts.

    `results`: None if only a comparison was made.
    `*regressions`: the comparison of each engine, None if it wasn't compared; at least one
        comparison or `results` must be given.
    """
    limits = None if results is None else of_limits(results)
    found = [of_comparison(one) for one in regressions if one is not None]
    compared = min(found, key=lambda one: _SIGNS.index(one.sign), default=None)
    answers = [answer for answer in (limits, compared) if answer is not None]
    sign = min((answer.sign for answer in answers), key=_SIGNS.index)
    words = [answer.word for answer in answers]
    if limits is not None and compared is not None:
        if compared.sign == "✓":
            words = [limits.word]
        elif limits.sign == "✓":
            words = [limits.word.replace(PASSED, "All limits passed"), compared.word]
    word = ", ".join(words)
    if limits is not None and limits.besides:
        word += f"{_BESIDES}{limits.besides}"
    why = " ".join(answer.why for answer in ([] if limits is None else [limits]) + found)
    kind = _KINDS[sign]
    if kind == "pass" and limits is not None and limits.besides:
        # No check failed, but something that no check judges is wrong: amber, without a tick.
        sign, kind = "≈", "holds"
    return Overall(sign, word[0].upper() + word[1:], kind, why)


def of_limits(results: Results) -> Answer:
    """Return the verdict on the limits of all cases."""
    verdicts = Counter(map(verdict_of, results.cases))
    failed, crashed = verdicts[Verdict.FAIL], verdicts[Verdict.CRASHED]
    if failed or crashed:
        parts = [f"{failed} failed"] * bool(failed) + [f"{crashed} did not finish"] * bool(crashed)
        ended = "" if results.state == "complete" else " The run is incomplete."
        said = f"Of {many(verdicts.total(), 'case')}, {', '.join(parts)}.{ended}"
        return Answer("✗", "Failed", said)
    if results.state != "complete":
        return Answer("!", "Incomplete", "No failure so far; the run is incomplete.")
    passed = sum(check.passed is True for case in results.cases for check in case.checks)
    if not passed:
        return Answer("○", "Nothing judged", "No limit applies to these cases (exit status 4).")
    if why := not_judged(results.cases):
        said = f"{why[0].upper()}{why[1:]}(exit status 4)."
        return Answer("○", "Final positions not judged", said)
    wrong = wrong_text(results.cases)
    word = "All limits passed" if wrong else PASSED
    return Answer("✓", word, f"Every check passed: {passed}.", wrong)


def of_comparison(regression: Regression) -> Answer:
    """Return the verdict on a comparison; for a failure, also how long `regress` will fail."""
    count = many(len(regression.scenes), "scene")
    failed = [one for one in regression.scenes if one.failed]
    rest = [one for one in regression.scenes if not one.failed]
    uncompared = [one for one in rest if one.change in UNCOMPARED]
    moved = [one for one in rest if one not in uncompared]
    moved = [one for one in moved if one.moved]
    said = []
    if failed:
        verb = "fails" if len(failed) == 1 else "fail"
        said.append(f"{len(failed)} of {count} {verb} ({kinds_text(failed)})")
    if moved:
        others = "other" if failed else f"of {count}"
        said.append(f"{len(moved)} {others} changed as allowed ({kinds_text(moved)})")
    if uncompared:
        said.append(f"{len(uncompared)} of {count} could not be compared")
    if not said:
        said.append(f"nothing changed in {count}" if regression.scenes else "nothing was compared")
    of = "" if regression.label == OURS else f" of `{regression.label}`"
    why = f"Compared with the accepted baselines{of}, {'; '.join(said)}"
    if regression.fail_on in LENIENT:
        why += f"; {LENIENT[regression.fail_on]}"
    gate = commands.regress(engine=regression.label)
    if regression.outcome == "failed":
        until = (
            " until the engine is fixed"
            if regression.broken
            else " until the change is reverted or accepted"
        )
        return Answer("✗", "baseline check failed", f"{why}: `{gate}` fails{until}.")
    if regression.outcome == "no-baseline":
        return Answer("?", "not all scenes compared", f"{why}: `{gate}` ends with exit status 4.")
    return Answer("✓", "baseline check passed", f"{why}.")


def coloured(change: SceneChange) -> str:
    """Return the change of a scene, in rich's markup."""
    return f"[{_COLOURS.get(CHANGES[change.change][0], 'yellow')}]{change.words}[/]"


def kinds_text(changes: Sequence[SceneChange]) -> str:
    """Return the number of changes by class, the most severe first: "1 worse, 2 rounding"."""
    order = sorted(changes, key=lambda one: [*CHANGES].index(one.change))
    return ", ".join(f"{n} {kind}" for kind, n in Counter(one.words for one in order).items())


def counts_text(results: Results) -> str:
    """Return the numbers of scenes and engines, and the number of cases by verdict.

    Two configurations of one engine count as one engine.
    """
    labels, engines = results.labels, {case.engine for case in results.cases}
    on = many(len(engines), "engine")
    if len(labels) != len(engines):
        on += f" in {many(len(labels), 'configuration')}"
    words = {
        Verdict.PASS: "passed",
        Verdict.FAIL: "failed",
        Verdict.CRASHED: "did not finish",
        Verdict.LIMITS_HOLD: "final positions not judged",
        Verdict.NOT_REPRESENTABLE: "unsupported",
    }
    rest = "not judged"
    found = Counter(words.get(verdict_of(case), rest) for case in results.cases)
    said = [one for one in (*words.values(), rest) if found[one] or one in ("passed", "failed")]
    counts = ", ".join(f"{found[one]} {one}" for one in said)
    return f"{many(len(results.scene_names), 'scene')} on {on}: {counts}"


def incomplete_text(results: Results) -> str:
    """Return how many cases of an incomplete run are done; "" if the run is complete."""
    if results.state == "complete":
        return ""
    done = f"{len(results.cases)} of {many(results.planned, 'case')} are done"
    state = "still running, or killed" if results.state == "running" else results.state
    return f"The run is incomplete ({state}): {done}."


class Failure(NamedTuple):
    """A failed limit with its reason, or, if `check` is None, a case that did not finish."""

    case: CaseRecord
    check: Check | None
    words: str
    reason: str


def failures(cases: Iterable[CaseRecord]) -> Iterator[Failure]:
    """Yield the failures of a run, in the order of its cases."""
    for case in cases:
        if is_unfinished(case):
            yield Failure(case, None, f"did not finish: {unfinished_text(case)}", "")
        for check in case.broken:
            yield Failure(case, check, check.sentence, check.reason)
