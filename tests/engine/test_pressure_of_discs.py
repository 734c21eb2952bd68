"""Tests of the pressure of hard discs, from collisions of an elastic gas, against literature."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from ghostball.engine import simulate
from ghostball.model import POOL_BALL_RADIUS as RADIUS, EventKind, ExactTrajectory, Result
from ghostball.validation.checks.relations import scene_from_end
from ghostball.validation.stress.gas import collision_rate, gas

LAYERS = 10.0 * RADIUS
"""Distance from a cushion beyond which the gas is as in the middle [m]: five diameters."""

BLOCKS = 20
"""Number of parts of a run; the scatter between them gives the error of the pressure."""

MIXING = 30.0
"""Number of collisions of each disc before the gas is measured."""

SIGMAS = 4.0
"""Permitted error of a pressure, in standard errors."""


VIRIAL = (
    1.0,
    4.0 / 3.0 - math.sqrt(3.0) / math.pi,
    2.0 - 4.5 * math.sqrt(3.0) / math.pi + 10.0 / math.pi**2,
    0.33355604,
    0.1988425,
    0.1148728,
    0.0649930,
    0.0362193,
    0.0199537,
)
"""B_(k+2) / B_2^(k+1) of hard discs: Clisby and McCoy 2006, J. Stat. Phys. 122 15, table 1."""

TAIL_RATIOS = (0.53, 0.57)
"""Range of the ratio of consecutive virial coefficients beyond the known ones.

From B_8 on, the known ratios are 0.566, 0.557 and 0.551.
"""


def places_of(
    result: Result, balls: NDArray[np.int64], times: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the position and the velocity of each ball at its own time: (k, 2) each."""
    places, velocities = np.empty((len(times), 2)), np.empty((len(times), 2))
    assert isinstance(result.trajectory, ExactTrajectory)
    for i, segments in enumerate(result.trajectory.segments):
        mine = np.flatnonzero(balls == i)
        segment = segments[np.searchsorted(segments[:, 0], times[mine], side="right") - 1]
        velocities[mine] = segment[:, 3:5]
        places[mine] = (
            segment[:, 1:3] + (times[mine] - segment[:, 0])[:, np.newaxis] * segment[:, 3:5]
        )
    return places, velocities


def literature(packing: float) -> tuple[float, float]:
    """Return p / (n k T) of hard discs with a packing fraction, and its uncertainty.

    Notes
    -----
    The value is 1 + the sum of B_(k+1) / B_2^k (2 x)^k. Beyond B_10 the sum is continued as a
    geometric series; its ratio is between `TAIL_RATIOS`, which gives the uncertainty: 0.33 % at x =
    0.6, and less than 0.05 % at 0.5 and below.
    """
    y = 2.0 * packing
    known = 1.0 + sum(b * y ** (k + 1) for k, b in enumerate(VIRIAL))
    last = VIRIAL[-1] * y ** len(VIRIAL)
    low, high = (last * r * y / (1.0 - r * y) for r in TAIL_RATIOS)
    return known + 0.5 * (low + high), 0.5 * (high - low)


def middle_of(result: Result, begin: float, end: float) -> tuple[float, float, float, float, float]:
    """Return what a run contributes to the state in the middle of its table between two times [s].

    The results are discs times seconds, seconds, collisions, the sum of their approach speeds
    [m/s], and the temperature k T [J] times the seconds.
    """
    assert result.events is not None
    table = result.scene.table
    assert table is not None
    low, high = LAYERS, table.length - LAYERS
    states = result.sample(np.linspace(begin, end, 40, endpoint=False))
    places = states.positions[:, :, :2]
    discs = np.mean(np.sum(np.all((places > low) & (places < high), axis=2), axis=1))
    events = result.events
    collisions = events[
        (events["kind"] == EventKind.BALL_BALL) & (events["t"] >= begin) & (events["t"] < end)
    ]
    a, va = places_of(result, collisions["a"].astype(np.int64), collisions["t"])
    b, vb = places_of(result, collisions["b"].astype(np.int64), collisions["t"])
    inside = np.all((0.5 * (a + b) > low) & (0.5 * (a + b) < high), axis=1)
    between = (b - a)[inside]
    speeds = np.sum((vb - va)[inside] * between, axis=1) / np.hypot(*between.T)
    temperature = 0.5 * float(np.mean(np.sum(states.velocities**2, axis=2)))  # for a mass of 1 kg
    seconds = end - begin
    return (
        float(discs) * seconds,
        seconds,
        float(np.count_nonzero(inside)),
        float(np.sum(np.abs(speeds))),
        temperature * seconds,
    )


def state_of(parts: NDArray[np.float64], side: float) -> tuple[float, float, float]:
    """Return p / (n k T), the packing fraction, and the mean approach speed over Maxwell's value.

    By the virial theorem, p / (n k T) is 1 + the sum over collisions of m v_n d / (2 N k T t), with
    the collisions and the discs in the middle of the table. For v_n this uses the mean over
    collisions of discs with Maxwell's velocities, sqrt(pi k T / m).
    """
    discs, seconds, collisions, speeds, heat = parts.sum(axis=0).tolist()
    maxwell = math.sqrt(math.pi * heat / seconds)
    packing = discs / seconds / (side - 2.0 * LAYERS) ** 2 * math.pi * RADIUS**2
    return (
        1.0 + collisions * RADIUS * math.pi / maxwell / discs,
        packing,
        speeds / collisions / maxwell,
    )


@pytest.mark.slow
@pytest.mark.compiled
@pytest.mark.parametrize(("packing", "collisions"), [(0.1, 30_000), (0.3, 60_000), (0.5, 300_000)])
def test_the_pressure_is_that_of_the_literature(packing, collisions):
    """The tolerance is in standard errors, from a jackknife over blocks.

    The mean approach speed has the same tolerance.
    """
    rows = 24
    rate = collision_rate(rows**2, packing)
    scene = gas(rows, packing, MIXING * rows**2 / rate)
    result, parts = simulate(scene, max_events=10_000_000), []
    for _ in range(BLOCKS):
        following = scene_from_end(result, collisions / rate / BLOCKS)
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


def test_the_literature_is_a_known_equation_of_state():
    """Henderson (1975) is within 1/200 up to 0.5, and the series for low density is exact."""
    for x in (0.01, 0.1, 0.3, 0.5):
        assert literature(x)[0] == pytest.approx((1 + x**2 / 8) / (1 - x) ** 2, rel=5e-3)
    assert literature(1e-4)[0] == pytest.approx(1.0 + 2e-4 + 0.7820044 * 4e-8, abs=1e-11)
    right, unsure = literature(0.6)
    assert unsure / right == pytest.approx(0.0033, abs=5e-5)
    assert literature(0.5)[1] < 5e-4 * literature(0.5)[0]
