"""Tables shared by the terminal and the page: comparisons with the reference, and ensembles."""

from __future__ import annotations

from collections.abc import Iterator

from ghostball.reference_adapters.registry import OURS
from ghostball.reports import style
from ghostball.reports.accuracy import length_text
from ghostball.reports.shots import standing_text
from ghostball.reports.words import many
from ghostball.validation.results.comparisons import comparisons_of
from ghostball.validation.results.store import CaseRecord, Results
from ghostball.validation.suite.statistics import (
    FALSE_ALARMS,
    POWER,
    REST_POSITIONS,
    EnsembleVerdict,
    QuantityVerdict,
    ensemble_verdicts,
    runs_needed,
)

COMPARISON_HEADS = (
    "largest rest error",
    "of ball",
    "ball-ball / reference",
    "ball-cushion / reference",
    "largest energy difference",
    "at",
)
"""Headings of `comparison_cells`."""

COMPARISON_KEY = (
    "Rest positions: the largest rest error of a ball; in brackets if no limit judges it. "
    "Collisions: number in the run / number in the reference. Energy: the largest deviation from "
    "the reference energy, divided by the initial energy, and its time."
)
"""The meaning of the columns."""


ENSEMBLE_HEADS = ("scene", "engine", "finished", "rest positions", "verdict")

ENSEMBLE_KEY = (
    "Each scene from randomly perturbed initial states, the same for every engine; touching balls "
    "are only moved away from each other. Rest positions: rms distance of a ball from its mean "
    f"rest position. Verdict: the distributions compared with those of `{OURS}`, which is no "
    "independent reference, by Kolmogorov-Smirnov tests and the energy distance of the rest "
    "positions. An engine with the right distributions is called different in at most "
    f"1 of {1.0 / FALSE_ALARMS:.0f} scenes; a difference of the stated size is found in "
    f"{POWER:.0%} of the scenes."
)

QUANTITY_HEADS = ("scene", "engine", "quantity", "mean", "difference", "p", "visible")


def comparison_cells(case: CaseRecord) -> tuple[str, ...] | None:
    """Return the cells of one case, see `COMPARISON_HEADS`; None if it didn't run."""
    found = comparisons_of(case)
    if found is None:
        return None
    rest = standing_text(case, length_text(case, found.rest_error))
    counts = []
    for count, true in found.counts.values():
        differs = "" if true is None or count == true else " ≠"
        counts.append(f"{count} / {'–' if true is None else true}{differs}")
    when = found.energy_time
    return (
        "the reference" if case.is_own_measure else rest or "–",
        found.rest_ball or "–",
        *counts,
        style.format_quantity(found.energy_difference),
        "–" if when is None else f"{when:.4g} s",
    )


def ensemble_rows(results: Results) -> Iterator[list[str]]:
    """Yield a row for each scene and engine with an ensemble."""
    last = ""
    for one in ensemble_verdicts(results):
        scene, last = "" if one.scene == last else one.scene, one.scene
        spread = "–" if one.position_spread is None else style.format_length(one.position_spread)
        finished = f"{one.ended} of {one.planned}"
        yield [scene, one.label, finished, spread, ensemble_words(one)]


def ensemble_words(one: EnsembleVerdict) -> str:
    """Return the verdict on an ensemble in a sentence, without a full stop."""
    if one.label == OURS:
        return "the reference of the other engines"
    if not one.quantities:
        return "nothing to compare: too few runs finished"
    if one.different:
        level = f"p < {FALSE_ALARMS:g}"
        said = "; ".join(f"{q.name.partition(' [')[0]}, by {_by(q)}" for q in one.different)
        more = "" if one.exact else " (allowed: the engine doesn't claim to be exact here)"
        return f"different from the reference with {level} in {said}{more}"
    if one.is_blind:
        least = runs_needed(len(one.quantities))
        return f"not judged: {one.ended} runs can't show a difference, {least} or more can"
    seen = "; ".join(
        f"{q.name.partition(' [')[0]} {_size(q.visible, q.name)}"
        for q in one.quantities
        if q.visible
    )
    return f"not distinguishable with {one.ended} runs; smallest visible difference: {seen}"


def quantity_rows(results: Results) -> Iterator[list[str]]:
    """Yield a row for each quantity of each compared ensemble, see `QUANTITY_HEADS`."""
    for one in ensemble_verdicts(results):
        for q in one.quantities:
            mean = "–" if q.name == REST_POSITIONS else f"{q.mean:.4g} ± {q.deviation:.2g}"
            visible = "–" if q.visible is None else _size(q.visible, q.name)
            yield [one.scene, one.label, q.name, mean, _by(q), f"{q.p:.2g}", visible]


def _by(q: QuantityVerdict) -> str:
    sign = "+" if q.by > 0.0 and q.name != REST_POSITIONS else ""
    return sign + _size(q.by, q.name)


def _size(value: float, name: str) -> str:
    unit = name.partition("[")[2].rstrip("]")
    return f"{value:.3g} {unit}".strip()


def ensemble_remarks(results: Results) -> Iterator[str]:
    """Yield a sentence for each scene and engine with failures in its ensemble."""
    for one in ensemble_verdicts(results):
        if said := _wrong(one):
            yield f"{one.scene} on {one.label}: {said}"


def _wrong(one: EnsembleVerdict) -> str:
    said = []
    if one.reasons:
        said.append(f"{many(one.planned - one.ended, 'run')} did not finish: {one.reasons[0]}")
    if one.broken:
        said.append(f"{many(one.broken, 'finished run')} failed a common limit")
    return "; ".join(said)
