"""Time reversal: elastic shots without friction, reversed after some time, return to their start.

Each collision of round balls multiplies errors by about ten, so after some dozens of collisions per
ball, rounding alone prevents the return. Later reversals aren't judged; see `checks.relations`.
"""

from __future__ import annotations

from collections.abc import Iterator

from ghostball.model import POOL_BALL_RADIUS as RADIUS, Ball, Scene, Table
from ghostball.validation.checks.criterion import Criterion
from ghostball.validation.checks.relations import RETURN_DISTANCE
from ghostball.validation.grading.tolerances import ROUNDINGS
from ghostball.validation.stress.gas import ICE, gas
from ghostball.validation.stress.shots import (
    StressFamily,
    StressShot,
    StressSize,
    limit,
    scene_of,
    shot,
)

LENGTHS = tuple(2.0**k for k in range(-5, 6))
"""Times of reversal [s], as long as rounding permits the return: see `longest`."""

FACTOR = limit(
    "reversal_factor",
    "Allows several roundings at each event instead of one, and cancellation.",
    claiming="rounding",
    at_most=ROUNDINGS,
)


def back_within(radius: float) -> Criterion:
    """Return the limit on the distance from the start after the return, for a radius [m]."""
    why = "Without dissipation, and if rounding allows it, the reversed shot returns to its start."
    return limit("reversal_error", why, at_most=RETURN_DISTANCE * radius)


def _there_and_back(name: str, scene: Scene, longest: float) -> Iterator[StressShot]:
    """Yield a shot with later and later reversals.

    `longest` [s]: the latest reversal; later, rounding alone would prevent the return.
    """
    for length in LENGTHS:
        if length <= longest:
            yield shot(
                f"{name}-after-{length:g}",
                scene.model_copy(update={"t_max": length}),
                back_within(float(scene.radii.min())),
                FACTOR,
                truth="none",
                length=length,
            )


def _line() -> Scene:
    """Return three balls on a line between two cushions, where errors don't grow exponentially."""
    return scene_of(
        Ball(id="a", position=(0.2, 0.5), velocity=(1.0, 0.0), mass=1.0),
        Ball(id="b", position=(0.5, 0.5), velocity=(-0.3, 0.0), mass=2.5),
        Ball(id="c", position=(0.8, 0.5), velocity=(0.7, 0.0), mass=0.7),
        physics=ICE,
        t_max=1.0,
        table=Table(length=1.0, width=1.0, cushions=("left", "right")),
    )


def _unlike(scene: Scene) -> Scene:
    """Return the gas with balls of different sizes and masses."""
    balls = tuple(
        Ball(
            id=ball.id,
            position=ball.position[:2],
            velocity=ball.velocity[:2],
            radius=RADIUS * (0.5 + 0.25 * (i % 3)),
            mass=1.0 + 0.7 * (i % 4),
        )
        for i, ball in enumerate(scene.balls)
    )
    return scene.model_copy(update={"balls": balls})


def _shots(size: StressSize) -> Iterator[StressShot]:
    for rows in (2, 3, 4, 6, 10) if size.full else (3,):
        for packing in (0.1, 0.4) if size.full else (0.2,):
            for seed in (1, 2) if size.full else (1,):
                scene = gas(rows, packing, 1.0, seed + size.seed)
                name = f"gas-{rows**2}-{packing:g}-{seed}"
                yield from _there_and_back(name, scene, min(0.1 / packing, 0.5))
    if size.full:
        yield from _there_and_back("unlike-16", _unlike(gas(4, 0.3, 1.0)), 0.5)
    yield from _there_and_back("line", _line(), 32.0 if size.full else 4.0)


FAMILY = StressFamily(
    "reversal",
    "Time reversal",
    "A frictionless elastic shot, reversed after 1/32 s, 1/16 s, 1/8 s ..., returns to its start "
    "within a thousandth of a radius. A shot is judged only if "
    f"{ROUNDINGS:g} times the rounding error of the way back, by the tangent map, is smaller than "
    "this limit. An engine whose only error is rounding returns within "
    f"{ROUNDINGS:g} times this rounding error.",
    _shots,
)
