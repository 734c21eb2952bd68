"""Judges for shots in which no number is known beforehand, but much that no shot may break.

>>> Sound(most_events=200)(result)
Verdict(faults=(), ...)

How well exact motion must keep to it, and an engine that steps, `judges.py` says.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ghostball.engine import ExactTrajectory, Result, Samples, Scene
from ghostball.engine.trajectory import energy_of
from ghostball.validation.grading.tolerances import EPS
from ghostball.validation.stress.judges import (
    FloatArray,
    energy_rise,
    instants,
    is_exact,
    overlap_limit,
    overlaps,
    rise_limit,
    solver_noise,
    way_of_a_step,
)
from ghostball.validation.stress.trial import Judge, Verdict

MOST_DISTANCES = 4_000_000
"""Distances of two balls that are computed in one run: of more instants, some are left out."""

MIRROR_OF_CONTACT = 2.0**-28
"""Asymmetry of exact motion, in diameters, where contact steps took part; without them, none.

2e-10 m for pool balls. Their forces are found by iteration over the contacts, in some order. What
that leaves is less than the tolerance of a gap; in a rack, where it may also change which of two
contacts of almost one instant comes first, it becomes visible, and `Sound.skew` is set higher."""


@dataclass(frozen=True)
class Sound:
    """Whether a run is possible at all: nothing overlaps, no energy comes in, no storm of events.

    Attributes
    ----------
    most_events : int
        Events that the shot may have.
    most_steps : int
        Contact steps that it may take, of an engine that counts them.
    isolated : bool
        Whether nothing external acts on the balls, and so their momentum stays.
    images : tuple of int
        Of a shot that is its own mirror image in y = 0 (`swapped`: in x = y), each ball's image;
        empty where it isn't.
    swapped : bool
    skew : float
        Asymmetry [diameters] that is permitted to exact motion with contact steps.
    still : tuple of int
        Balls that nothing moves, and that must stay where they are: to the bit, if motion is exact.
    """

    most_events: int
    most_steps: int = 0
    isolated: bool = False
    images: tuple[int, ...] = ()
    swapped: bool = False
    skew: float = MIRROR_OF_CONTACT
    still: tuple[int, ...] = ()

    def __call__(self, result: Result) -> Verdict:
        """Judge a run, recorded as a trajectory."""
        scene = result.scene
        times = telling_instants(result)
        found = dict(self._measured(result, result.sample(times)))
        faults = [
            f"{name} of {value:.3g}, at most {limit:.3g}"
            for name, (value, limit) in found.items()
            if not value <= limit
        ]
        nearest = max((value / limit for value, limit in found.values() if limit > 0.0), default=0)
        values = {name: value for name, (value, _) in found.items()}
        return Verdict.of(scene, faults, nearest, values)

    def _measured(
        self, result: Result, states: Samples
    ) -> Iterator[tuple[str, tuple[float, float]]]:
        """Yield what is measured: its name, its value, and the most that it may be."""
        scene = result.scene
        exact = is_exact(result)
        diameter = 2.0 * float(scene.radii.max())
        step = 0.0 if exact else way_of_a_step(result)
        deepest = overlap_limit(result, states.positions)
        of_balls, of_cushion = np.maximum(overlaps(scene, states.positions).max(axis=0), 0.0)
        yield "overlap of ball and cushion [m]", (float(of_cushion), deepest)
        if exact:
            yield "overlap of balls [m]", (float(of_balls), deepest)
            rise = energy_rise(energy_of(scene, states).total)
            yield "rise of the energy [1]", (rise, rise_limit(result))
        assert result.events is not None
        yield "number of events", (float(len(result.events)), float(self.most_events))
        steps = float(result.work.get("contact_steps", 0))
        yield "number of contact steps", (steps, float(self.most_steps))
        for name, count in result.work.items():
            if name.startswith("unsolved"):
                yield f"number of {name.replace('_', ' ')}", (float(count), 0.0)
        if self.isolated:
            some = EPS * (8.0 + len(result.events))  # some roundings at each impact
            change = momentum_change(scene, states)
            yield "change of the momentum [1]", (change, some if exact else solver_noise())
        if self.images:
            limit = (self.skew if steps else 0.0) if exact else max(self.skew, step / diameter)
            skew = asymmetry(states.positions, self.images, self.swapped) / diameter
            yield "asymmetry [diameters]", (skew, limit)
        if self.still:
            kept = scene.positions[list(self.still)]
            moved = np.abs(states.positions[:, list(self.still)] - kept)
            yield (
                "way of a ball that nothing moves [m]",
                (
                    float(moved.max()),
                    0.0 if exact else solver_noise() * diameter,
                ),
            )


@dataclass(frozen=True)
class Ends:
    """Whether a shot ends as it is known to.

    Attributes
    ----------
    velocities : n tuples of 2 floats [m/s]
        At the end.
    collisions : int or None
        How many collisions there are; None where that isn't known.
    positions : n tuples of 2 floats [m], or empty
        At the end; empty where they aren't known.
    roundings : float
        How many roundings of the fastest ball's speed, and of the coordinates, an exact engine may
        be off by.
    slack : tuple of 2 floats [m], [m/s]
        Beyond these, how far apart the places and the velocities are that it may choose from.
    """

    velocities: tuple[tuple[float, float], ...]
    collisions: int | None = None
    positions: tuple[tuple[float, float], ...] = ()
    roundings: float = 32.0
    slack: tuple[float, float] = (0.0, 0.0)

    def __call__(self, result: Result) -> Verdict:
        """Judge a run."""
        scene = result.scene
        exact = is_exact(result)
        faults = []
        counted = sum(result.collision_counts.values())
        if self.collisions is not None and counted != self.collisions:
            faults.append(f"{counted} collisions instead of {self.collisions}")
        speed = float(np.max(np.abs(scene.velocities)))
        limit = self.roundings * EPS if exact else solver_noise()
        limit += self.slack[1] / speed
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
            apart = np.abs(result.rest_positions[:, :2] - self.positions).max(axis=1)
            limit = self.roundings * EPS * float(size) if exact else way_of_a_step(result)
            limit += self.slack[0]
            ball = int(np.argmax(apart))
            if not apart[ball] <= limit:
                faults.append(
                    f"ball {scene.balls[ball].id} ends {apart[ball]:.3g} m from where it must, "
                    f"at most {limit:.3g}"
                )
            nearest = max(nearest, float(apart[ball]) / limit)
            values["position_error"] = float(apart[ball])
        return Verdict.of(scene, faults, nearest, values)


@dataclass(frozen=True)
class Both:
    """Two judges of one run: it survives where it does with each."""

    first: Judge
    second: Judge

    def __call__(self, result: Result) -> Verdict:
        """Judge a run, recorded as a trajectory."""
        return self.first(result).joined(self.second(result))


def telling_instants(result: Result, between: int = 3) -> FloatArray:
    """Return when a run is looked at, (k,) [s], increasing.

    As `instants`; in exact motion also wherever a ball's motion changes without an event, and just
    before. Where that is more than `MOST_DISTANCES` allows: some of them, evenly taken, and the
    end.
    """
    times = instants(result, between)
    if isinstance(result.trajectory, ExactTrajectory):
        changes = np.concatenate([knots[:, 0] for knots in result.trajectory.knots])
        changes = changes[(changes > 0.0) & (changes <= result.rest_time)]
        times = np.unique(np.concatenate((times, changes, np.nextafter(changes, 0.0))))
    most = max(MOST_DISTANCES // len(result.scene.balls) ** 2, 2)
    if len(times) > most:
        times = times[np.linspace(0, len(times) - 1, most).round().astype(np.int64)]
    return times


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
