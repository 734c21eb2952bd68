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
from ghostball.validation.suite.spread import DIFFERS, QUANTITIES, SceneSpread, Spread, spreads_of

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


SPREAD_HEADS = ("scene", "engine", "finished", "rest positions", *QUANTITIES)

SPREAD_KEY = (
    "Each scene from randomly perturbed initial states, the same for every engine; touching balls "
    "are only moved away from each other. Rest positions: rms distance of a ball from its mean "
    "rest position. "
    "Other columns: the mean ± the standard deviation of one shot, and the difference from the "
    "mean of "
    f"`{OURS}` in standard errors; ≠ if it is more than {DIFFERS:g}. This table compares "
    "engines with each other, not with a reference."
)


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


def spread_rows(results: Results) -> Iterator[list[str]]:
    """Yield a row for each scene and engine with an ensemble."""
    last = ""
    for one in spreads_of(results):
        scene, last = "" if one.scene == last else one.scene, one.scene
        position_spread = (
            "–" if one.position_spread is None else style.format_length(one.position_spread)
        )
        cells = [_spread_cell(one.quantities.get(name)) for name in QUANTITIES]
        yield [scene, one.label, f"{one.ended} of {one.planned}", position_spread, *cells]


def spread_remarks(results: Results) -> Iterator[str]:
    """Yield a sentence for each scene and engine with failures in its ensemble."""
    for one in spreads_of(results):
        if said := _wrong(one):
            yield f"{one.scene} on {one.label}: {said}"


def _spread_cell(found: Spread | None) -> str:
    if found is None:
        return "–"
    text = f"{found.mean:.4g} ± {found.deviation:.2g}"
    if found.standard_errors is None:
        return text
    return f"{'≠ ' * found.differs}{text} ({found.standard_errors:+.1f})"


def _wrong(one: SceneSpread) -> str:
    said = []
    if one.reasons:
        said.append(f"{many(one.planned - one.ended, 'run')} did not finish: {one.reasons[0]}")
    if one.broken:
        said.append(f"{many(one.broken, 'run')} that finished failed a common limit")
    return "; ".join(said)
