"""How much the ends of varied starts vary, in words and numbers: for the page and the terminal."""

from __future__ import annotations

from collections.abc import Iterator

from ghostball.reference_adapters.registry import OURS
from ghostball.reports import style
from ghostball.reports.words import many
from ghostball.validation.results.store import Results
from ghostball.validation.suite.spread import DIFFERS, QUANTITIES, SceneSpread, Spread, spreads_of

HEADER = ("scene", "engine", "ended", "rest positions", *QUANTITIES)

KEY = (
    "Each scene from starts varied at random, the same for every engine; touching balls are varied "
    "by opening gaps alone. Rest positions: how far a ball rests from where it does on average, "
    "root mean square. Else the mean ± the standard deviation of one shot, and how many standard "
    f"errors the mean is from that on `{OURS}`: ≠ where it is more than {DIFFERS:g}. That "
    "compares engines, none with truth."
)


def rows_of(results: Results) -> Iterator[list[str]]:
    """Yield a row for each scene and engine that varied starts were played on."""
    last = ""
    for one in spreads_of(results):
        scene, last = "" if one.scene == last else one.scene, one.scene
        position_spread = (
            "–" if one.position_spread is None else style.format_length(one.position_spread)
        )
        cells = [_cell(one.quantities.get(name)) for name in QUANTITIES]
        yield [scene, one.label, f"{one.ended} of {one.planned}", position_spread, *cells]


def remarks_of(results: Results) -> Iterator[str]:
    """Yield what is wrong with varied starts, a sentence for each scene and engine."""
    for one in spreads_of(results):
        if said := _wrong(one):
            yield f"{one.scene} on {one.label}: {said}"


def _cell(found: Spread | None) -> str:
    if found is None:
        return "–"
    text = f"{found.mean:.4g} ± {found.deviation:.2g}"
    if found.standard_errors is None:
        return text
    return f"{'≠ ' * found.differs}{text} ({found.standard_errors:+.1f})"


def _wrong(one: SceneSpread) -> str:
    said = []
    if one.reasons:
        said.append(f"{many(one.planned - one.ended, 'start')} without an end: {one.reasons[0]}")
    if one.broken:
        said.append(f"{many(one.broken, 'start')} that end break a limit of every engine")
    return "; ".join(said)
