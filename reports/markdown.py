"""What the page says of a whole run, in Markdown: headline, truth, what was counted."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from ghostball.reports.counted import COUNTED_MEANS, counted_rows, unsolved
from ghostball.reports.markdown_parts import (
    many,
    table_of,
)
from ghostball.reports.outcome import bad_cases
from ghostball.validation.checks.metric_table import METRICS
from ghostball.validation.checks.verdict import (
    Verdict,
    verdict_of,
)
from ghostball.validation.results.store import Results

NAMED = 12
"""How many cases that are not right are named at the top."""

UNAVAILABLE = "unavailable here"
"""Stands for the settings of an engine that could not run, which has none."""

STATES = {
    "running": "it is still running, or was killed",
}
"""What became of a run that isn't complete, where its state alone doesn't say it."""


TRUTH_TEXT = """\
**Closed form**: rest positions, rest time and order of collisions come from formulas, evaluated to
50 digits, that share nothing with any engine; a rest error there is an error.

**Certified**: every event of the shot is proved and every rest position enclosed, by code in ball
arithmetic that shares no formula with `ghostball`. Energy curves are compared with the proved
motion, also where there is a closed form.

**Our engine (not independent)**: the scene has no closed form and isn't proved to its end, so the
others are compared with `ghostball`, also their energy. That is a comparison of codes, not a proof:
`ghostball` has no class there and can't pass by it, only fail by what needs no truth, such as
energy, and by the part of the shot that is proved.

**Judged** is an outcome that a check limits: where or when the balls rest, or how many and which
collisions there were. Energy that falls as it should, no deep overlap, the first collisions: these
can all be right in a shot that ends wrong, so they alone make no ✓ but a ≈.

Agreement between two engines is never called truth. After a few dozen collisions any two engines
part, since each collision multiplies the smallest difference; that is chaos, not a mistake.
"""


def headline(results: Results) -> str:
    """Return what became of all cases in numbers, with those that are not right by name."""
    verdicts = [verdict_of(case) for case in results.cases]
    passed, failed = verdicts.count(Verdict.PASS), verdicts.count(Verdict.FAIL)
    holding = verdicts.count(Verdict.LIMITS_HOLD)
    crashed = verdicts.count(Verdict.CRASHED)
    unable = verdicts.count(Verdict.NOT_REPRESENTABLE)
    counts = (
        f"{many(len(results.scene_names), 'scene')} on {_engines_text(results)}: "
        f"**{passed} passed, {failed} failed**"
        + (f", **{crashed} did not finish**" if crashed else "")
        + f", {holding} keep their limits without "
        f"their outcome being judged, {unable} not representable, "
        f"{len(verdicts) - passed - holding - failed - crashed - unable} without a verdict."
    )
    if left := unsolved(results):
        counts += f" **{many(left, 'sustained or joint contact')} left unsolved.**"
    if bad := bad_cases(results):
        named = [f"[{case.scene}](#{case.scene}) on `{case.label}`" for case in bad[:NAMED]]
        more = [f"{len(bad) - NAMED} more, in the table"] if len(bad) > NAMED else []
        counts += f"\n\nNot right: {', '.join(named + more)}."
    if results.state == "complete":
        return counts
    why = STATES.get(results.state, results.state)
    return (
        f"> **This run is not complete**: {why}; {len(results.cases)} of "
        f"{many(results.planned, 'case')} are done.\n\n{counts}"
    )


def metrics_text(results: Results) -> str:
    """Say which metrics were measured, where it isn't all, and what that leaves unjudged."""
    measured = results.environment.get("metrics", list(METRICS))
    if len(measured) == len(METRICS):
        return ""
    left_out = sum(len(case.left_out) for case in results.cases)
    were = "was" if left_out == 1 else "were"
    return (
        f"> **Only some metrics were measured**: {', '.join(f'`{name}`' for name in measured)}. "
        f"{many(left_out, 'limit')} on others {were} not judged, so a verdict says nothing "
        "of them."
    )


def _engines_text(results: Results) -> str:
    """Say how many engines there are; one with other settings is no other engine."""
    labels, engines = results.labels, {case.engine for case in results.cases}
    text = many(len(engines), "engine")
    if len(labels) == len(engines):
        return text
    return f"{text} in {many(len(labels), 'configuration')}"


def counted_section(results: Results) -> str:
    """Say by engine what runs did beyond exact events."""
    rows = [
        [f"`{label}`", words, str(total), where]
        for label, words, total, where in counted_rows(results)
    ]
    if not rows:
        return ""
    header = ["engine", "what", "how often", "where"]
    return f"## What the runs counted\n\n{COUNTED_MEANS}\n\n{table_of(header, rows)}"


def engine_settings(results: Results) -> dict[str, dict[str, Any] | None]:
    """Return the settings of each engine as used, by its label; None where it is unavailable.

    The environment has them as asked for, where a step may be left to the engine.
    """
    used = {case.label: case.settings for case in reversed(results.cases) if case.outcome == "ran"}
    asked: dict[str, dict[str, Any] | None] = results.environment.get("engine_settings", {})
    return {**asked, **used}


def flat_values(values: Mapping[str, Any]) -> Iterable[tuple[str, str]]:
    """Yield a row for each value, for a mapping one for each of its entries."""
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from ((f"{key}.{inner}", _plain(entry)) for inner, entry in value.items())
        else:
            yield key, _plain(value)


def _plain(value: Any) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{key}={_plain(entry)}" for key, entry in value.items())
    if isinstance(value, list):
        return ", ".join(map(_plain, value))
    return str(value)
