"""What engines make of measured cushions: rebounds of two games, and banks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from ghostball.model import Physics
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.measured.banks import through_points
from ghostball.validation.measured.best import best_cloth, best_cushion
from ghostball.validation.measured.facts import facts_of
from ghostball.validation.measured.family import Family, Measured, family_of
from ghostball.validation.measured.play import Play
from ghostball.validation.measured.rebounds import rebounds, square_rebound

ANGLES: Final = (5.0, 45.0)
"""From the normal: what was measured hardly depends on it [degrees]."""

_LACKS = "it has no law of cushions that turns balls"


def carom_rebounds(engine: ReferenceEngine, play: Play) -> tuple[Family, Family]:
    """Return the rebounds of a match of three-cushion, and how they change with speed."""
    facts = facts_of("cushion-carom")
    ratio = family_of(facts, "cushion", "rebound")
    slope = family_of(
        facts,
        "cushion-slope",
        "rebound against speed",
        title=f"{facts.title}: how they change with speed",
        quantity=f"slope of the {facts.quantity}, by weighted least squares",
        unit="s/m",
    )
    cushion = best_cushion("cushion-carom", engine.name, engine.capabilities)
    if cushion is None:
        return ratio.lacking(_LACKS), slope.lacking(_LACKS)

    def figures() -> tuple[Measured, ...]:
        cloth = best_cloth("rolling-carom", engine.capabilities)
        physics = Physics(preset="carom", **{**cloth, **cushion})
        return tuple(
            Measured.of(one.row, one.ratio)
            for degrees in ANGLES
            for one in rebounds(play, physics, degrees)
        )

    ratio = ratio.played(cushion, figures)
    if ratio.lacks:
        return ratio, slope.lacking(ratio.lacks, failed=ratio.failed)
    count = len(ratio.figures) // len(ANGLES)
    of_each = [ratio.figures[k * count : (k + 1) * count] for k in range(len(ANGLES))]
    return ratio, slope.played(cushion, lambda: tuple(map(_slope, of_each)))


def _slope(figures: Sequence[Measured]) -> Measured:
    """Return the slope of measured and of played figures, by the same weighted least squares."""
    at, value, error, played = np.array(
        [(one.at, one.value, one.error, one.played) for one in figures]
    ).T
    slopes, covariance = np.polyfit(at, value, 1, w=1.0 / error, cov="unscaled")
    return Measured(
        at=float(np.mean(at)),
        value=float(slopes[0]),
        error=float(np.sqrt(covariance[0, 0])),
        played=float(np.polyfit(at, played, 1, w=1.0 / error)[0]),
    )


def snooker_rebounds(engine: ReferenceEngine, play: Play) -> Family:
    """Return the square rebounds of a snooker table."""
    facts = facts_of("cushion-snooker")
    family = family_of(facts, "cushion-snooker", "snooker rebound")
    cushion = best_cushion("cushion-snooker", engine.name, engine.capabilities)
    if cushion is None:
        return family.lacking(_LACKS)

    def figures() -> tuple[Measured, ...]:
        physics = Physics(preset="snooker", **cushion)
        return tuple(
            Measured.of(row, square_rebound(play, physics, row.place).normal_ratio * row.place)
            for row in facts.rows
        )

    return family.played(cushion, figures)


def banks(engine: ReferenceEngine, play: Play) -> Family:
    """Return slid banks, beside those of five pool tables."""
    facts = facts_of("banks-pool")
    family = family_of(facts, "banks-pool", "bank")
    cushion = best_cushion("banks-pool", engine.name, engine.capabilities)
    if cushion is None:
        return family.lacking(_LACKS)

    def figures() -> tuple[Measured, ...]:
        aims = [row.place for row in facts.rows]
        found = through_points(play, Physics(preset="pool", **cushion), aims)
        return tuple(Measured.of(*one) for one in zip(facts.rows, found, strict=True))

    return family.played(cushion, figures)
