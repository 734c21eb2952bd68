"""Judges for shots of which it is known how they end, or what no such shot may break.

>>> Invariants(most_events=200)(result)
Verdict(faults=(), ...)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ghostball.model import Result, Samples, Scene
from ghostball.model.arrays import FloatArray
from ghostball.validation.grading.tolerances import EPS
from ghostball.validation.stress.invariants import (
    MOST_DISTANCES,
    Measured,
    faults_in,
    instants,
    is_exact,
    measured,
    solver_noise,
    travel_in_a_step,
)
from ghostball.validation.stress.trial import Judge, Verdict

MIRROR_OF_CONTACT = 2.0**-28
"""Asymmetry of exact motion, in diameters, where contact steps took part; without them, none.

2e-10 m for pool balls. Their forces are found by iteration over the contacts, in some order. What
that leaves is less than the tolerance of a gap; in a rack, where it may also change which of two
contacts of almost one instant comes first, it becomes visible, and `Invariants.skew` is set higher.
"""


END_ROUNDINGS = 32.0
"""Roundings of the fastest speed, and of the coordinates, by which an exact end may be off."""


@dataclass(frozen=True)
class Invariants:
    """Whether a run is possible at all: nothing overlaps, no energy comes in, no storm of events.

    `most_events`: events that the shot may have; None where neither they nor contact steps are
        counted.
    `most_steps`: contact steps that it may take, of an engine that counts them.
    `isolated`: whether nothing external acts on the balls, and so their momentum stays.
    `images`: of a shot that is its own mirror image in y = 0 (`swapped`: in x = y), each ball's
        image; empty where it isn't.
    `skew`: asymmetry [diameters] that is permitted to exact motion with contact steps.
    `still`: balls that nothing moves, and that must stay where they are: to the bit, if motion is
        exact.
    `random`: whether the shot is a random one of any features. Such a one may have thousands of
        events, last for days, or have a law that is integrated: their roundings are permitted.
    `looks`: instants at which it is looked at, at most.
    """

    most_events: int | None = None
    most_steps: int = 0
    isolated: bool = False
    images: tuple[int, ...] = ()
    swapped: bool = False
    skew: float = MIRROR_OF_CONTACT
    still: tuple[int, ...] = ()
    random: bool = False
    looks: int = MOST_DISTANCES

    def __call__(self, result: Result) -> Verdict:
        """Judge a run, recorded as a trajectory."""
        times = instants(result, most=self.looks)
        found = measured(result, times, self.random) | self._more(result, result.sample(times))
        faults = faults_in(found)
        nearest = max((value / limit for value, limit in found.values() if limit > 0.0), default=0)
        values = {name: value for name, (value, _) in found.items()}
        return Verdict.of(result.scene, faults, nearest, values)

    def _more(self, result: Result, states: Samples) -> Measured:
        """Return what is measured of this shot beside what holds of any."""
        scene, exact, found = result.scene, is_exact(result), Measured()
        diameter = 2.0 * float(scene.radii.max())
        assert result.events is not None
        steps = float(result.work.get("contact_steps", 0))
        if self.most_events is not None:
            found["number of events"] = (float(len(result.events)), float(self.most_events))
            found["number of contact steps"] = (steps, float(self.most_steps))
        if self.isolated:
            some = EPS * (8.0 + len(result.events))  # some roundings at each impact
            limit = some if exact else solver_noise()
            found["change of the momentum [1]"] = (momentum_change(scene, states), limit)
        if self.images:
            skew = asymmetry(states.positions, self.images, self.swapped) / diameter
            if exact:
                limit = self.skew if steps else 0.0
            else:
                limit = max(self.skew, travel_in_a_step(result) / diameter)
            found["asymmetry [diameters]"] = (skew, limit)
        if self.still:
            kept = scene.positions[list(self.still)]
            moved = float(np.abs(states.positions[:, list(self.still)] - kept).max())
            limit = 0.0 if exact else solver_noise() * diameter
            found["way of a ball that nothing moves [m]"] = (moved, limit)
        return found


@dataclass(frozen=True)
class Ends:
    """Whether a shot ends as it is known to.

    `velocities` [m/s]: at the end.
    `collisions`: how many collisions there are; None where that isn't known.
    `positions` [m]: at the end; empty where they aren't known.
    """

    velocities: tuple[tuple[float, float], ...]
    collisions: int | None = None
    positions: tuple[tuple[float, float], ...] = ()

    def __call__(self, result: Result) -> Verdict:
        """Judge a run."""
        scene = result.scene
        exact = is_exact(result)
        faults = []
        counted = sum(result.collision_counts.values())
        if self.collisions is not None and counted != self.collisions:
            faults.append(f"{counted} collisions instead of {self.collisions}")
        speed = float(np.max(np.abs(scene.velocities)))
        limit = END_ROUNDINGS * EPS if exact else solver_noise()
        off = np.abs(result.final_state.velocities[0, :, :2] - self.velocities).max(axis=1) / speed
        ball = int(np.argmax(off))
        if not off[ball] <= limit:
            got = result.final_state.velocities[0, ball, :2].tolist()
            faults.append(
                f"ball {scene.balls[ball].id} ends with velocity {got} m/s instead of "
                f"{list(self.velocities[ball])}: off by {off[ball]:.3g} of the first speed, "
                f"at most {limit:.3g}"
            )
        nearest = float(off[ball]) / limit
        values = {"velocity_error": float(off[ball]), "collisions": counted}
        if self.positions:
            size = max(np.abs(self.positions).max(), np.abs(scene.positions).max())
            away = np.abs(result.rest_positions[:, :2] - self.positions).max(axis=1)
            limit = END_ROUNDINGS * EPS * float(size) if exact else travel_in_a_step(result)
            ball = int(np.argmax(away))
            if not away[ball] <= limit:
                faults.append(
                    f"ball {scene.balls[ball].id} ends {away[ball]:.3g} m from where it must, "
                    f"at most {limit:.3g}"
                )
            nearest = max(nearest, float(away[ball]) / limit)
            values["position_error"] = float(away[ball])
        return Verdict.of(scene, faults, nearest, values)


@dataclass(frozen=True)
class Both:
    """Two judges of one run: it survives where it does with each."""

    first: Judge
    second: Judge

    def __call__(self, result: Result) -> Verdict:
        """Judge a run, recorded as a trajectory."""
        return self.first(result).joined(self.second(result))


def momentum_change(scene: Scene, states: Samples) -> float:
    """Return how far the momentum ever gets from the first, over the most that balls ever have."""
    each = scene.masses[:, np.newaxis] * states.velocities[:, :, :2]
    total = each.sum(axis=1)
    size = float(np.abs(each).sum(axis=(1, 2)).max())
    return float(np.abs(total - total[0]).max()) / size if size > 0.0 else 0.0


def asymmetry(positions: FloatArray, images: tuple[int, ...], swapped: bool) -> float:
    """Return how far balls ever are from their mirror images [m], in y = 0 or in x = y."""
    plane = positions[:, :, :2]
    mirrored = plane[:, :, ::-1] if swapped else plane * np.array([1.0, -1.0])
    return float(np.abs(plane[:, list(images)] - mirrored).max())
