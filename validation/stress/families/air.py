"""Air: frozen racks, rails and corners where air slows the balls, put to all that is the same."""

from __future__ import annotations

from collections.abc import Iterator

from ghostball.validation.stress.same.trials import trials_of
from ghostball.validation.stress.trial import Family, Suite, Trial


def _trials(suite: Suite) -> Iterator[Trial]:
    size, chunks = (20, 1) if suite == "quick" else (100, 5)
    for layout in ("corner", "rail", "rack-at-rail", "rack", "touching"):
        yield from trials_of(f"air-{layout}", size, chunks, air="yes", layout=layout)
        yield from trials_of(f"quadratic-{layout}", size, chunks, quadratic="yes", layout=layout)
    yield from trials_of("air-along-rail", size, chunks, air="yes", along_rail="yes")
    yield from trials_of("air-narrow", size, chunks, air="yes", table="narrow")


FAMILY = Family(
    "air",
    "Balls in air",
    "Balls that begin frozen to a rail, into a corner or to each other, or go along a rail that "
    "they touch, in air or on a cloth that slows fast balls by more: they end, overlap nothing, "
    "and come out the same to the bit however they are played.",
    _trials,
    ours_alone=True,
)
