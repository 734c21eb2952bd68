"""Every failure explained: what was expected and found, why, what it may mean, how to see it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from markupsafe import Markup

from ghostball.reports.outcome import bad_cases, kind_text
from ghostball.reports.page.numbers import COMPARISONS
from ghostball.reports.page.rendering import render
from ghostball.reports.page.scenes import ScenePart
from ghostball.reports.words import number_text, quantity_text
from ghostball.validation.baselines import Regression
from ghostball.validation.baselines.regression import SceneChange, moved_text
from ghostball.validation.checks.verdict import is_unfinished, unfinished_text
from ghostball.validation.results.store import CaseRecord, Check, Results
from ghostball.validation.scenes import commands
from ghostball.validation.scenes.library import scene_names
from ghostball.validation.truth.scene_truth import OUR_NAME

MEANINGS = {
    "rest_error_max": "a contact seen too late or too early, an impact law or a friction that "
    "differs, or a collision that is missing: the first other event tells them apart",
    "rest_error_rms": "as the largest rest error, but of many balls rather than of one",
    "rest_error_ulps": "more than rounding: a formula or its order of operations is not exact",
    "rest_time_error": "friction, or the speed after an impact, differs",
    "rest_time_error_ulps": "more than rounding in the time of rest",
    "ball_ball_count": "a collision of two balls was missed, counted twice, or invented",
    "ball_ball_count_error": "a collision of two balls was missed, counted twice, or invented",
    "ball_cushion_count": "a cushion was passed through, or counted twice",
    "ball_cushion_count_error": "a cushion was passed through, or counted twice",
    "collision_count": "collisions were missed, counted twice, or invented",
    "matching_events": "the shot takes another course from some collision on",
    "events_missing": "a proved event was passed over: tunnelling, or a root that was not found",
    "events_invented": "an event that is proved not to happen: overlap, or a root that is none",
    "event_time_error_ulps": "events come at the wrong instant",
    "quality_factor": "errors larger than rounding are made at events",
    "energy_difference_max": "energy is lost or gained where it should not be",
    "energy_drift": "a motion that should keep its energy does not",
    "energy_rise": "energy was made from nothing: an impulse too large, or overlap pushed apart",
    "overlap_max": "balls went into each other before the contact was seen",
    "wall_time": "it got slower; single samples vary with what else the machine does",
}
"""What a broken limit on a metric may mean: where to look first."""

CRASHED = (
    "an exception, a crash of the engine's process, the limit of time, or a limit of the engine's "
    "own; the reason says which"
)

CHANGED = {
    "worse": "an error that the base didn't have: the first other event says where to look",
    "not-deterministic": "something random without a seed, threads that race, or memory that is "
    "read before it is written",
    "results-changed": "another course or another rounding; where it is right, accept it",
    "better": "nearer to the truth; where that is meant, accept it",
    "rounding-only": "another order of operations; where that is meant, accept it",
    "identical": "the same answer for another cost",
}
"""What a change that fails the gate may mean."""

BROKEN = "limits of truth are broken: this is wrong, not only another answer"
"""What a change means that breaks a limit."""

SHOWN_BALLS = 3
"""Of a shot with more, where the others are in the scene's table."""


@dataclass(frozen=True)
class Explained:
    """One failure, in words.

    Attributes
    ----------
    what, expected, found, reason, meaning : str
    command : str
        The one that does it again; of a case, to the hash.
    why : str
        The one that says where it leaves the true shot; "" where there is none.
    rests : list of (str, str, str)
        Ball, x and y [m] that it must give again, to the bit.
    bits : str
        Hash of the events and rest positions that it must give, to the bit; "" where it didn't run.
    traceback : str
    anchor : str
        The place in the page that shows it.
    """

    scene: str
    label: str
    what: str
    expected: str
    found: str
    reason: str
    meaning: str
    command: str
    why: str
    rests: list[tuple[str, str, str]]
    more: int
    bits: str
    traceback: str
    anchor: str


def failures_html(
    results: Results, scenes: Mapping[str, ScenePart], regression: Regression | None
) -> Markup:
    """Return all that failed, explained: checks, cases that did not finish, changes."""
    failures = list(explained(results, scenes, regression))
    return render("failures.html", failures=failures, own=_own_scenes(results))


def explained(
    results: Results, scenes: Mapping[str, ScenePart], regression: Regression | None
) -> Iterator[Explained]:
    """Yield every failure of a run, in the order of its cases; then what fails the gate."""
    for case in bad_cases(results):
        bits = scenes[case.scene].hashes.get(case.label, "")
        if is_unfinished(case):
            yield _explain(case, None, bits)
        for check in case.checks:
            if check.passed is False:
                yield _explain(case, check, bits)
    if regression is not None:
        for change in regression.scenes:
            if change.failed:
                yield _explain_change(change)


def _explain_change(change: SceneChange) -> Explained:
    quantities = (*change.metrics, *change.counters)
    left = [one for one in quantities if not one.within and one.level == "error"]
    same_bits = change.base_hash == change.head_hash
    expected = [
        "what the accepted baselines gave",
        *([] if same_bits or not change.base_hash else [f"hash {change.base_hash}"]),
    ]
    first = [] if change.first_difference is None else [change.first_difference.words]
    return Explained(
        scene=change.scene,
        label=OUR_NAME,
        what=kind_text(change),
        expected=", ".join(expected),
        found="; ".join([change.summary, *first, *map(moved_text, left)]),
        reason="; ".join(dict.fromkeys(one.why for one in left)),
        meaning=BROKEN if change.broken else CHANGED.get(change.change, "see its summary"),
        command=change.command,
        why="",
        rests=[],
        more=0,
        bits="",
        traceback="",
        anchor=f"change={change.scene}",
    )


def _explain(case: CaseRecord, check: Check | None, bits: str) -> Explained:
    rests = []
    if case.rest_positions is not None:
        ids = [ball["id"] for ball in case.definition["balls"]]
        rests = [
            (str(name), repr(float(x)), repr(float(y)))
            for name, (x, y, _) in zip(ids, case.rest_positions, strict=True)
        ]
    unit = "" if check is None or check.unit == "1" else f" {check.unit}"
    if check is None:
        what, expected, found = "did not finish", "a run to its end", unfinished_text(case)
        reason, meaning = "", CRASHED
    else:
        what = check.metric
        expected = f"{COMPARISONS[check.limit_kind]} {quantity_text(check.limit, check.unit)}"
        exactly = "" if check.value is None else f" ({number_text(check.value)}{unit})"
        found = check.note if check.value is None else quantity_text(check.value, check.unit)
        found = f"no value: {found}" if check.value is None else found + exactly * bool(unit)
        reason = check.reason
        meaning = MEANINGS.get(check.metric, "what its metric says; see its reason")
    return Explained(
        scene=case.scene,
        label=case.label,
        what=what,
        expected=expected,
        found=found,
        reason=reason,
        meaning=meaning,
        command=commands.simulate(case.scene, case.label, recorded=True),
        why=explaining(case),
        rests=rests[:SHOWN_BALLS],
        more=max(len(rests) - SHOWN_BALLS, 0),
        bits=bits,
        traceback=case.traceback,
        anchor=f"scene={case.scene}",
    )


def explaining(case: CaseRecord) -> str:
    """Return the command that says where a case leaves the true shot, and why.

    "" where our engine, or none, has a run: there is nothing to part from.
    """
    explains = case.outcome == "ran" and case.engine != OUR_NAME
    return commands.explain(case.scene, case.label) if explains else ""


def _own_scenes(results: Results) -> list[str]:
    """Return the scenes that aren't shipped: their commands need their files."""
    shipped = scene_names()
    return [name for name in results.scene_names if name not in shipped]
