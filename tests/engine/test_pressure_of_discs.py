"""The pressure of hard discs, from the collisions of an elastic gas, against the literature."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from ghostball.engine import EventKind, Result, simulate
from ghostball.engine.scene import POOL_BALL_RADIUS as RADIUS
from ghostball.validation.stress.gas import begun_at_end, collision_rate, gas, literature, places_of

LAYERS = 10.0 * RADIUS
"""How far from a cushion the gas is as in the middle [m]: five diameters."""

BLOCKS = 20
"""Parts of a run from whose scatter the error of its pressure is estimated."""

MIXING = 30.0
"""Collisions of each disc before its gas is measured."""

SIGMAS = 4.0
"""Standard errors that a pressure may be off."""


def middle_of(result: Result, begin: float, end: float) -> tuple[float, float, float, float, float]:
    """Return what a run says of the middle of its table between two instants [s].

    Discs times seconds, seconds, collisions, the sum of their speeds of approach [m/s], and the
    temperature k T [J] times the seconds.
    """
    assert result.events is not None
    table = result.scene.table
    assert table is not None
    low, high = LAYERS, table.length - LAYERS
    states = result.sample(np.linspace(begin, end, 40, endpoint=False))
    places = states.positions[:, :, :2]
    discs = np.mean(np.sum(np.all((places > low) & (places < high), axis=2), axis=1))
    events = result.events
    hits = events[
        (events["kind"] == EventKind.BALL_BALL) & (events["t"] >= begin) & (events["t"] < end)
    ]
    a, va = places_of(result, hits["a"].astype(np.int64), hits["t"])
    b, vb = places_of(result, hits["b"].astype(np.int64), hits["t"])
    inside = np.all((0.5 * (a + b) > low) & (0.5 * (a + b) < high), axis=1)
    apart = (b - a)[inside]
    speeds = np.sum((vb - va)[inside] * apart, axis=1) / np.hypot(*apart.T)
    temperature = 0.5 * float(np.mean(np.sum(states.velocities**2, axis=2)))  # of 1 kg
    seconds = end - begin
    return (
        float(discs) * seconds,
        seconds,
        float(np.count_nonzero(inside)),
        float(np.sum(np.abs(speeds))),
        temperature * seconds,
    )


def state_of(parts: NDArray[np.float64], side: float) -> tuple[float, float, float]:
    """Return p / (n k T), the packing, and the mean speed of approach over Maxwell's.

    By the virial theorem p / (n k T) is 1 + the sum over collisions of m v_n d / (2 N k T t), for
    those in the middle and the discs there; for v_n its mean over collisions of discs with
    Maxwell's velocities, sqrt(pi k T / m), is taken.
    """
    discs, seconds, hits, speeds, heat = parts.sum(axis=0).tolist()
    maxwell = math.sqrt(math.pi * heat / seconds)
    packing = discs / seconds / (side - 2.0 * LAYERS) ** 2 * math.pi * RADIUS**2
    return 1.0 + hits * RADIUS * math.pi / maxwell / discs, packing, speeds / hits / maxwell


@pytest.mark.slow
@pytest.mark.compiled
@pytest.mark.parametrize(("packing", "collisions"), [(0.1, 30_000), (0.3, 60_000), (0.5, 300_000)])
def test_the_pressure_is_that_of_the_literature(packing, collisions):
    """Within as many standard errors, of the jackknife over blocks; so is the speed of approach."""
    rows = 24
    rate = collision_rate(rows**2, packing)
    scene = gas(rows, packing, MIXING * rows**2 / rate)
    result, parts = simulate(scene, max_events=10_000_000), []
    for _ in range(BLOCKS):
        following = begun_at_end(result, collisions / rate / BLOCKS)
        result = simulate(following, record="trajectory", max_events=10_000_000)
        parts.append(middle_of(result, 0.0, result.rest_time))
    blocks, side = np.array(parts), scene.table.length
    state, found, speed = state_of(blocks, side)
    left_out = np.array(
        [
            (one - literature(there)[0], approach)
            for k in range(BLOCKS)
            for one, there, approach in [state_of(np.delete(blocks, k, axis=0), side)]
        ]
    )
    error, scatter = np.sqrt((BLOCKS - 1) * np.var(left_out, axis=0))
    right, unsure = literature(found)
    assert error <= 0.005 * right
    assert abs(state - right) <= SIGMAS * math.hypot(error, unsure)
    assert abs(speed - 1.0) <= SIGMAS * scatter
