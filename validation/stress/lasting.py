"""Impacts that last: rows and racks whose gaps close within an impact."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from ghostball.model import Physics
from ghostball.validation.checks.criterion import Criterion
from ghostball.validation.stress import common_limits
from ghostball.validation.stress.common_limits import ISOLATED, bounded, symmetric
from ghostball.validation.stress.shots import (
    StressFamily,
    StressShot,
    StressSize,
    limit,
    scene_of,
    shot,
    size_of,
)
from ghostball.validation.stress.touching import STEPS_PER_BALL, ball, resting_row, triangle

KINDS = {
    "elastic": Physics(rolling_friction=0.0, impacts="compliant"),
    "sliding": Physics(
        motion="sliding", impacts="compliant", ball_restitution=0.95, ball_friction=0.06
    ),
}

EVENTS_PER_BALL = 28
"""Largest number of events per ball: three times that of any row or rack, 9.3 in a row of 8."""

INTEGRATION = 6e-6
"""Relative error of the energy for each impact of a chain of impacts.

Speeds are integrated to within 3e-6 (`tests/engine/impacts/test_compliant.py`), and the energy has
twice this error.
"""


POSSIBLE = (
    *common_limits.POSSIBLE,
    limit("overlap_max", "No contact has more energy than the shot.", at_most=1.0, of="touching"),
)


def _energy(kind: str, impacts: int) -> tuple[Criterion, ...]:
    """Return the limits on the energy of a chain of impacts, which are those of the integration."""
    why = "Each impact of the chain is integrated to within 3e-6 of the speeds."
    metrics = ("energy_rise", "energy_drift") if kind == "elastic" else ("energy_rise",)
    return tuple(limit(metric, why, at_most=INTEGRATION * impacts) for metric in metrics)


def _gaps(size: StressSize) -> tuple[float, ...]:
    return (0.0, 1e-9, 1e-6, 1e-5, 1e-4, 3e-4, 1e-3) if size.full else (0.0, 1e-4)


def _rows(size: StressSize) -> Iterator[StressShot]:
    """Yield a ball that hits a row of balls full."""
    numbers = (2, 3, 5, 8, 15) if size.full else (2, 5)
    for (kind, physics), n, gap in product(KINDS.items(), numbers, _gaps(size)):
        cue = ball("cue", (-0.125, 0.0), (2.0, 0.0))
        name = f"row-of-{n}-{kind}-gap-{size_of(gap)}"
        scene = scene_of(cue, *resting_row(n, gap), physics=physics, t_max=0.1)
        alone = ISOLATED if kind == "elastic" else ()
        last = limit(
            "ball_ball_count",
            "Each ball of the row is pushed: there are at least as many collisions as balls.",
            at_least=n,
        )
        events = bounded(EVENTS_PER_BALL * (n + 1), STEPS_PER_BALL * n)
        yield shot(
            name,
            scene,
            *POSSIBLE,
            *events,
            *_energy(kind, n),
            *alone,
            last,
            *symmetric(0.0),
            gap=gap,
        )


def _triangles(size: StressSize) -> Iterator[StressShot]:
    """Yield a straight break of a triangle."""
    numbers = (2, 3, 5, 8) if size.full else (5,)
    for (kind, physics), rows, gap in product(KINDS.items(), numbers, _gaps(size)):
        cue = ball("cue", (-0.125, 0.0), (8.0, 0.0))
        rack = [ball(f"b{k}", place) for k, place in enumerate(triangle(rows, gap), start=1)]
        name = f"triangle-of-{rows}-rows-{kind}-gap-{size_of(gap)}"
        scene = scene_of(cue, *rack, physics=physics, t_max=0.05)
        alone = ISOLATED if kind == "elastic" else ()
        events = bounded(EVENTS_PER_BALL * len(rack), STEPS_PER_BALL * len(rack))
        yield shot(
            name, scene, *POSSIBLE, *events, *_energy(kind, rows), *alone, *symmetric(0.0), gap=gap
        )


def _shots(size: StressSize) -> Iterator[StressShot]:
    yield from _rows(size)
    yield from _triangles(size)


FAMILY = StressFamily(
    "lasting",
    "Impacts that last",
    "Rows and racks with gaps of 0 to 1e-3 m are hit full, with impacts that last. Energy never "
    "rises, no overlap needs more energy than the shot has, the cloth alone changes the momentum, "
    "and straight shots keep their mirror symmetry.",
    _shots,
)
