"""How much work one sample is, and the made scenes that it is measured on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from benchmarks.running import after, collision_rate, until
from benchmarks.scenes import racked_break, random_rack
from ghostball.engine import Scene
from ghostball.validation.scenes.gases import FRICTIONLESS, packed_gas

PACKING = 0.6
"""Of the elastic gases: the part of the area that balls cover."""

MELTING = 20.0
"""Collisions of each ball after which nothing is left of the lattice of the start."""


@dataclass(frozen=True)
class Size:
    """How much work a sample is; the small one shows that all of it runs, and times nothing.

    Attributes
    ----------
    racks : int
        Random breaks.
    mixed_racks : int
        Random racks, loose and frozen ones.
    gas_time : float [s]
        For how long 16 balls bounce on a table.
    gas_collisions : float
        Collisions of each ball of a packed gas in one sample.
    most_balls : int
        More are never placed.
    shots : int
    runs : int
        Of a shipped scene in one sample.
    """

    racks: int = 100
    mixed_racks: int = 1_000
    gas_time: float = 500.0
    gas_collisions: float = 20.0
    most_balls: int = 100_000
    shots: int = 100_000
    runs: int = 15


FULL = Size()
QUICK = Size(
    racks=2,
    mixed_racks=5,
    gas_time=2.0,
    gas_collisions=2.0,
    most_balls=20,
    shots=20,
    runs=1,
)


def break_scenes(physics: dict[str, Any], size: Size) -> tuple[Scene, ...]:
    """Return the random racks that breaks are measured on; the same ones each time."""
    return tuple(racked_break(seed, physics) for seed in range(size.racks))


def rack_scenes(size: Size) -> tuple[Scene, ...]:
    """Return random racks, half of them loose and half frozen; the same ones each time."""
    return tuple(random_rack(number) for number in range(size.mixed_racks))


def gas_scene(count: int, size: Size) -> Scene:
    """Return a melted elastic gas that runs for a sample's number of collisions."""
    each = 1.0 / collision_rate(PACKING)  # seconds between two collisions of a ball
    melting = min(MELTING, size.gas_collisions) * each
    gas = packed_gas(min(count, size.most_balls), PACKING, FRICTIONLESS, t_max=melting)
    return until(after(gas), size.gas_collisions * each)
