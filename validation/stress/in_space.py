"""A judge for shots in which balls fly: what must hold in space, whatever the shot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ghostball.engine import EventKind, Result, Status
from ghostball.engine.core.tolerances import LOWEST_HOP
from ghostball.engine.trajectory import Phase, energy_of
from ghostball.validation.stress.judges import (
    energy_rise,
    gap_rounding,
    rise_limit_of_many,
    unsolved,
)
from ghostball.validation.stress.sound import telling_instants
from ghostball.validation.stress.trial import Verdict

SUNK = 4.0 * LOWEST_HOP
"""Overlap, in diameters, of what is pressed together in flight: it hops instead of being held."""


@dataclass(frozen=True)
class SoundInSpace:
    """Whether a run in which balls fly is possible at all; and whether two balls meet in it.

    Attributes
    ----------
    meets : bool or None
        Whether two balls meet; None where that isn't asked.
    """

    meets: bool | None = None

    def __call__(self, result: Result) -> Verdict:
        """Judge a run, recorded as a trajectory."""
        found = measured(result)
        faults = [
            f"{name} of {value:.3g}, at most {limit:.3g}"
            for name, (value, limit) in found.items()
            if not value <= limit  # nor where it is NaN
        ]
        assert result.events is not None
        met = bool(np.any(result.events["kind"] == EventKind.BALL_BALL))
        if self.meets is not None and met != self.meets:
            faults.append("two balls meet that don't" if met else "a ball goes through another")
        nearest = max(value / limit for value, limit in found.values() if limit > 0.0)
        return Verdict.of(
            result.scene, faults, nearest, {name: value for name, (value, _) in found.items()}
        )


def measured(result: Result, between: int = 3) -> dict[str, tuple[float, float]]:
    """Return what is measured of a run: by its name, its value and the most that it may be.

    At its events, just before, and at so many instants between two.
    """
    scene = result.scene
    times = telling_instants(result, between)
    states = result.sample(times)
    here = result.phases(times) != Phase.GONE
    places, radii = states.positions, scene.radii
    rounding = gap_rounding(scene, places)
    sunk = rounding + SUNK * 2.0 * float(radii.max())
    found = {"depth in the table [m]": (float((radii - places[:, :, 2]).max()), rounding)}
    first, second = np.triu_indices(len(radii), 1)
    if len(first):
        apart = np.linalg.norm(places[:, first] - places[:, second], axis=2)
        depth = np.where(here[:, first] & here[:, second], radii[first] + radii[second] - apart, -1)
        found["overlap of balls [m]"] = (float(depth.max()), sunk)
    if scene.table is not None:
        x, y = places[:, :, 0], places[:, :, 1]
        above = places[:, :, 2] - scene.physics.cushion_height
        length, width = scene.table.length, scene.table.width
        inward = {"left": x, "right": length - x, "bottom": y, "top": width - y}
        for side in scene.table.cushions:
            away = np.maximum(inward[side], 0.0)
            depth = np.where(here, radii - np.hypot(away, above), -1)
            before = found.get("overlap of ball and nose [m]", (-1.0, sunk))[0]
            found["overlap of ball and nose [m]"] = (max(float(depth.max()), before), sunk)
    energy = energy_of(scene, states).total
    limit = rise_limit_of_many(result, times, states)
    found["rise of the energy [1]"] = (energy_rise(energy), limit)
    if result.status is Status.REST:
        last = result.sample([result.rest_time])
        on_cloth = result.phases(np.array([result.rest_time]))[0] != Phase.GONE
        above = np.where(on_cloth, np.abs(last.positions[0, :, 2] - radii), 0.0)
        found["height of a ball at rest over the cloth [m]"] = (float(above.max()), rounding)
    found["contact steps or joint impacts left unsolved"] = (float(unsolved(result)), 0.0)
    return found
