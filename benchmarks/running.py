"""What is run for a benchmark: our engine, random shots in processes, scenes that end elsewhere.

An interrupt, or a run that broke off, is no measurement.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import TypeVar

from benchmarks.scenes import later
from ghostball.engine import GhostballError, Record, Result, Scene, Status, simulate
from ghostball.engine.scene import POOL_BALL_RADIUS

T = TypeVar("T")
R = TypeVar("R")


class BenchError(GhostballError):
    """A measurement that can't be made, stored or read."""


def run(scene: Scene, *, record: Record = "rest", no_skip: Collection[str] = ()) -> Result:
    """Simulate `scene` to its natural end; arguments as for `simulate`.

    Raises
    ------
    KeyboardInterrupt
        Where the engine was interrupted, which it notes in its status.
    BenchError
        Where the run broke off: the time it took says nothing.
    """
    result = simulate(scene, record=record, no_skip=no_skip)
    if result.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    if not result.status.complete:
        raise BenchError(
            f'scene "{scene.name}" did not end by itself: {result.status.value}: {result.reason}. '
            "Its time would mean nothing"
        )
    return result


def until(scene: Scene, t_max: float) -> Scene:
    """Return the scene with another end [s]; its balls are the same objects."""
    return scene.model_copy(update={"t_max": t_max})


def collision_rate(packing: float) -> float:
    """Return how often a ball of an elastic gas meets another, at 1 m/s per component [1/s].

    Notes
    -----
    Enskog's rate of hard discs, 2 sqrt(pi) n D g sqrt(k T / m), with the contact value g =
    (1 - 7 x / 16) / (1 - x)^2 of Henderson (1975), x the part covered. It only decides for how long
    gases run.
    """
    contact = (1.0 - 7.0 * packing / 16.0) / (1.0 - packing) ** 2
    return 4.0 * packing * contact / (math.sqrt(math.pi) * POOL_BALL_RADIUS)


def after(scene: Scene) -> Scene:
    """Return a scene of rolling balls as it is when it ends: a lattice is a gas by then."""
    state = run(scene).final_state
    return later(scene, state.positions[0], state.velocities[0])
