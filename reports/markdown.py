"""The text of `report.md`, from a results folder and the figures that were drawn of it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import PurePosixPath
from statistics import median
from typing import Any

from reports import style
from reports.figures.summary import independent_errors
from reports.shots import (
    NUMBERS_KEY,
    cell_text,
    legend_text,
    rest_error,
    rest_error_text,
    standing_text,
)
from validation.metrics import METRICS
from validation.store import CLOSED_FORM, CaseRecord, Check, ResultsFolder
from validation.verdict import (
    RestError,
    Verdict,
    is_own_measure,
    rest_error_standing,
    verdict_of,
)

Drawn = Mapping[str, PurePosixPath]
"""Figures by kind: file without its ending, relative to the report."""

FIGURE_TITLES = {
    "paths": "Paths and rest positions",
    "errors": "Rest error against the limits",
    "energy": "Energy against time",
    "collisions": "Collisions counted",
}
FIGURE_TITLES_AT_END = {
    "paths": "Paths and final positions",
    "errors": "Error at the end against the limits",
}
"""Where a scene ends at its `t_max`, with balls in motion."""

PHYSICS_CAPTIONS = {
    "physics-deflection": "The 30 degree rule: deflection of a rolling cue ball by a cut",
    "physics-throw": "Throw of the object ball, against cut angle and against side spin",
}
PAPER_CAPTIONS = {
    "paper-figure-1": "Figure 1: a break of 7 balls at four instants",
    "paper-figure-2": "Figure 2: clipping, and the same instants without it",
    "paper-figure-3": "Figure 3: a ball meets a cushion",
    "paper-figure-4": "Figure 4: head-on against slightly skewed",
}
STATES = {
    "killed": "it was killed while it wrote a case",
    "running": "it is still running, or was killed",
}
"""What became of a run that isn't complete, where its state alone doesn't say it."""

COMPARISONS = {"at_most": "at most", "at_least": "at least", "equals": "exactly"}

_TRUTH = """\
**Closed form**: rest positions, rest time and order of collisions come from formulas, evaluated to
50 digits, that share nothing with any engine; a rest error there is an error.

**Our engine (not independent)**: the scene has no closed form, so the others are compared with
`ghostball`. That is a comparison of codes, not a proof: `ghostball` is marked *ref* there and can't
pass by it, only fail by what needs no truth, such as energy. Energy curves are always compared with
`ghostball`'s.

**Judged** is an outcome that a check limits: where or when the balls rest, or how many and which
collisions there were. Energy that falls as it should, no deep overlap, the first collisions: these
can all be right in a shot that ends wrong, so they alone make no ✓ but a ≈.

Agreement between two engines is never called truth. After a few dozen collisions any two engines
part, since each collision multiplies the smallest difference; that is chaos, not a mistake.
"""


def report_text(
    results: ResultsFolder,
    whole: Drawn,
    scenes: Mapping[str, Drawn],
    physics: Drawn,
    paper: Drawn,
) -> str:
    """Return the report as Markdown.

    Parameters
    ----------
    results : ResultsFolder
    whole : figures of the whole run
    scenes : figures of each scene, by its name
    physics : figures of laws of the game, over their closed forms
    paper : the paper's figures
    """
    parts = [
        "# Validation report",
        _headline(results),
        "## Verdicts",
        _verdict_table(results),
        _figure("Verdict and largest rest error", whole.get("verdicts")),
        "### Engines over all scenes",
        _engine_table(results),
        _figure("Rest errors in the closed-form scenes", whole.get("accuracy")),
        "## What is true here",
        _TRUTH,
        "## Scenes",
    ]
    for scene in results.scene_names:
        parts += _scene_section(results, scene, scenes.get(scene, {}))
    if physics:
        parts += ["## Laws of the game, from whole shots"]
        parts += [_figure(PHYSICS_CAPTIONS[kind], path) for kind, path in physics.items()]
    if paper:
        parts += ["## The paper's figures, remade"]
        parts += [_figure(PAPER_CAPTIONS[kind], path) for kind, path in paper.items()]
    parts += ["## Environment", _environment_table(results)]
    return "\n\n".join(part.strip() for part in parts if part.strip()) + "\n"


def _headline(results: ResultsFolder) -> str:
    verdicts = [verdict_of(case) for case in results.cases]
    passed, failed = verdicts.count(Verdict.PASS), verdicts.count(Verdict.FAIL)
    holding = verdicts.count(Verdict.LIMITS_HOLD)
    crashed = verdicts.count(Verdict.CRASHED)
    unable = verdicts.count(Verdict.NOT_REPRESENTABLE)
    counts = (
        f"{_many(len(results.scene_names), 'scene')} on {_engines_text(results)}: "
        f"**{passed} passed, {failed} failed**"
        + (f", **{crashed} did not finish**" if crashed else "")
        + f", {holding} keep their limits without "
        f"their outcome being judged, {unable} not representable, "
        f"{len(verdicts) - passed - holding - failed - crashed - unable} without a verdict."
    )
    if results.state == "complete":
        return counts
    why = STATES.get(results.state, results.state)
    lines = [
        f"> **This run is not complete**: {why}; {len(results.cases)} of "
        f"{_many(results.planned, 'case')} are done."
    ]
    if results.cut_short:
        place = results.cut_short.replace(str(results.path), ".", 1)
        lines.append(f"> The last line, `{place}`, was cut short and is left out.")
    return "\n".join(lines) + f"\n\n{counts}"


def _many(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def _engines_text(results: ResultsFolder) -> str:
    """Say how many engines there are; one with other settings is no other engine."""
    labels, engines = results.labels, {case.engine for case in results.cases}
    text = _many(len(engines), "engine")
    if len(labels) == len(engines):
        return text
    return f"{text} in {_many(len(labels), 'configuration')}"


def _verdict_table(results: ResultsFolder) -> str:
    header = ["scene", *(f"`{label}`" for label in results.labels)]
    rows = [
        [f"[{scene}](#{scene})", *(_verdict_cell(results.case(scene, e)) for e in results.labels)]
        for scene in results.scene_names
    ]
    return f"{_table(header, rows)}\n\n{_key(results.cases)}"


def _key(cases: Iterable[CaseRecord]) -> str:
    return f"{legend_text(map(verdict_of, cases))}. {NUMBERS_KEY}."


def _verdict_cell(case: CaseRecord | None) -> str:
    text = cell_text(case)
    return f"**{text}**" if verdict_of(case) in (Verdict.FAIL, Verdict.CRASHED) else text


def _engine_table(results: ResultsFolder) -> str:
    header = [
        "engine",
        "✓",
        "≈",
        "✗",
        "did not finish",
        "not representable",
        "rest error, closed form: median",
        "worst",
        "rest error, against ours: median",
        "counts right",
        "energy difference: median [1]",
        "run time: median",
    ]
    rows = []
    for label in results.labels:
        cases = [case for case in results.cases if case.label == label]
        verdicts = [verdict_of(case) for case in cases]
        errors = independent_errors(results, label)
        others = [
            error
            for case in cases
            if case.truth != CLOSED_FORM
            and rest_error_standing(case) in (RestError.JUDGED, RestError.UNJUDGED)
            and (error := rest_error(case)) is not None
        ]
        rows.append(
            [
                f"`{label}`",
                str(verdicts.count(Verdict.PASS)),
                str(verdicts.count(Verdict.LIMITS_HOLD)),
                str(verdicts.count(Verdict.FAIL)),
                str(verdicts.count(Verdict.CRASHED)),
                str(verdicts.count(Verdict.NOT_REPRESENTABLE)),
                style.format_length(median(errors) if errors else None),
                style.format_length(max(errors) if errors else None),
                style.format_length(median(others) if others else None),
                _counts_right(cases),
                _number(_median_metric(cases, "energy_difference_max")),
                style.format_time(_median_metric(cases, "wall_time")),
            ]
        )
    return _table(header, rows)


def _counts_right(cases: Sequence[CaseRecord]) -> str:
    names = ("ball_ball_count_error", "ball_cushion_count_error")
    judged = [
        [case.metrics[name] for name in names]
        for case in cases
        if not is_own_measure(case) and all(case.metrics.get(name) is not None for name in names)
    ]
    right = sum(all(error == 0 for error in errors) for errors in judged)
    return f"{right} of {len(judged)}" if judged else "–"


def _median_metric(cases: Sequence[CaseRecord], name: str) -> float | None:
    values = [
        float(value)
        for case in cases
        if (value := case.metrics.get(name)) is not None and math.isfinite(value)
        if not (METRICS[name].compares and is_own_measure(case))
    ]
    return median(values) if values else None


def _scene_section(results: ResultsFolder, scene: str, drawn: Drawn) -> list[str]:
    cases = [c for e in results.labels if (c := results.case(scene, e)) is not None]
    truth = next((case.truth for case in cases if case.truth), "none")
    tags = ", ".join(f"`{tag}`" for tag in cases[0].tags)
    parts = [
        f"### {scene}",
        f"{_escape(cases[0].title)}. Truth: {truth}." + (f" Tags: {tags}." if tags else ""),
        _collision_text(cases),
        _number_table(cases),
        _remarks(cases),
        _checks_table(cases),
    ]
    titles = FIGURE_TITLES
    if any(case.status == "t-max" for case in cases):
        titles = titles | FIGURE_TITLES_AT_END
    return parts + [_figure(titles[kind], path) for kind, path in drawn.items()]


def _collision_text(cases: Sequence[CaseRecord]) -> str:
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
    independent = truth.truth == CLOSED_FORM
    source = "in truth" if independent else "by our engine (not independent)"
    parts = [f"Collisions {source}: **{_counts(truth.truth_counts)}**"]
    agree, differ = ("Right", "Wrong") if independent else ("The same", "Different")
    parts += [f"{agree}: {', '.join(said[True])}"] if said[True] else []
    parts += [f"{differ}: {', '.join(said[False])}"] if said[False] else []
    return ". ".join(parts) + "."


def _counts(counts: Mapping[str, int]) -> str:
    kinds = [f"{count} {kind}" for kind, count in counts.items() if count]
    if len(kinds) < 2:
        return kinds[0] if kinds else "0"
    return f"{sum(counts.values())} ({', '.join(kinds)})"


def _number_table(cases: Sequence[CaseRecord]) -> str:
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
                standing_text(case, style.format_length(_metric(case, "rest_error_rms"))),
                "–" if case.rest_time is None else f"{case.rest_time:.6g}",
                _rest_time_error_text(case),
                str(case.collision_counts.get("ball-ball", "–")),
                str(case.collision_counts.get("ball-cushion", "–")),
                "–" if metrics.get("matching_events") is None else f"{metrics['matching_events']}",
                "" if own else _number(_metric(case, "energy_difference_max")),
                style.format_length(_metric(case, "overlap_max")),
                style.format_time(_metric(case, "wall_time")),
            ]
        )
    return _table(header, rows)


def _rest_time_error_text(case: CaseRecord) -> str:
    """Return the rest time's error; where the rest positions are past prediction, so is this."""
    if rest_error_standing(case) in (RestError.CHAOTIC, RestError.OWN):
        return rest_error_text(case)
    return style.format_time(_metric(case, "rest_time_error"))


def _remarks(cases: Sequence[CaseRecord]) -> str:
    lines = []
    for case in cases:
        if case.outcome != "ran":
            lines.append(f"- `{case.label}` {verdict_of(case).words}: {_escape(case.reason)}")
        elif case.reason:
            lines.append(f"- `{case.label}` stopped early ({case.status}): {_escape(case.reason)}")
        lines += [_failure(case, check) for check in case.checks if check.passed is False]
        if case.approximations:
            lines.append(
                f"- `{case.label}` approximates: {_escape('; '.join(case.approximations))}"
            )
    return "\n".join(lines)


def _failure(case: CaseRecord, check: Check) -> str:
    unit = "" if check.unit == "1" else f" {check.unit}"
    got = "has no value" if check.value is None else f"is {_number(check.value)}{unit}"
    limit = f"must be {COMPARISONS[check.limit_kind]} {_number(check.limit)}{unit}"
    why = "; ".join(_escape(text) for text in (check.reason, check.note) if text)
    return f"- **`{case.label}` fails**: `{check.metric}` {got}, {limit}" + (
        f" ({why})" if why else ""
    )


def _checks_table(cases: Sequence[CaseRecord]) -> str:
    """Return every limit with its reason, folded: a ✓ must be open to question."""
    rows = [
        [
            f"`{case.label}`",
            f"`{check.metric}`",
            "–" if check.value is None else _quantity(check.value, check.unit),
            f"{COMPARISONS[check.limit_kind]} {_quantity(check.limit, check.unit)}",
            {True: "✓", False: "✗", None: "ref"}[check.passed],
            _escape(check.reason),
        ]
        for case in cases
        for check in case.checks
    ]
    if not rows:
        return ""
    table = _table(["engine", "metric", "value", "limit", "", "why this limit"], rows)
    # Markdown inside HTML needs the empty lines.
    return (
        f"<details><summary>{_many(len(rows), 'check')}: limits and reasons</summary>\n\n"
        f"{table}\n\n</details>"
    )


def _quantity(value: float, unit: str) -> str:
    """Return a number as reports show it, a length or a time with the unit that suits it."""
    if unit == "m":
        return style.format_length(value)
    return style.format_time(value) if unit == "s" else _number(value)


def _environment_table(results: ResultsFolder) -> str:
    # Settings as used: `env.json` has them as asked for, where a step may be left to the engine.
    used = {case.label: case.settings for case in reversed(results.cases) if case.outcome == "ran"}
    asked = results.environment.get("engine_settings", {})
    environment = results.environment | {"engine_settings": asked | used}
    return _table(["what", "value"], [[f"`{k}`", _escape(v)] for k, v in _flat(environment)])


def _flat(values: Mapping[str, Any]) -> Iterable[tuple[str, str]]:
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


def _figure(caption: str, stem: PurePosixPath | None) -> str:
    return "" if stem is None else f"[![{caption}]({stem}.png)]({stem}.svg)"


def _table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def _escape(text: str) -> str:
    """Keep a text on one line and within its cell."""
    return " ".join(text.split()).replace("|", "\\|")


def _metric(case: CaseRecord, name: str) -> float | None:
    value = case.metrics.get(name)
    return None if value is None else float(value)


def _number(value: float | None) -> str:
    if value is None:
        return "–"
    return str(value) if isinstance(value, int) else f"{value:.3g}"
