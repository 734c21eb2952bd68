"""Curves of a scene's motions against time, which the page and the sheet of a scene both draw."""

from __future__ import annotations

import numpy as np

from ghostball.model import COLLISION_KINDS
from ghostball.model.arrays import FloatArray
from ghostball.reports.shots import Run, Shot
from ghostball.validation.results.store import Motion

ERROR_FLOOR = 1e-5
"""Smallest distance drawn [m].

Frames are joined by straight lines, which run beside a ball that slows down:
0.01 mm for frames of 20 ms on a common cloth, ten times that where it slides.
"""

UNITS = ((1e6, "MJ"), (1e3, "kJ"), (1.0, "J"))
"""Units of energy with the smallest one that they are for [J]; balls may be as heavy as cars."""

HIGHEST = 1.8
"""Energy drawn at most, over the initial one: one engine that explodes must not flatten all."""


def motion_of_run(run: Run) -> Motion:
    """Return the motion of a run that has one, as those of `Shot.drawn` do."""
    assert run.motion is not None
    return run.motion


def energy_scale(shot: Shot) -> tuple[float, str, float]:
    """Return the unit of energy that suits a shot [J], its name, and the most that is drawn [J]."""
    # An engine that blew up has no energy to scale by.
    start = max(largest(motion_of_run(run).energy[:1]) for run in shot.drawn)
    highest = max(largest(motion_of_run(run).energy) for run in shot.drawn)
    unit, name = next(((unit, name) for unit, name in UNITS if start >= unit), UNITS[-1])
    return unit, name, min(highest, HIGHEST * start)


def largest(values: FloatArray) -> float:
    """Return the largest finite value, 0 where there is none."""
    return float(np.max(values[np.isfinite(values)], initial=0.0))


def collision_times(motion: Motion) -> FloatArray:
    """Return the instants of all collisions in order of time, (k,) [s]."""
    times: FloatArray = motion.events["t"][np.isin(motion.events["kind"], COLLISION_KINDS)]
    return times


def distance_from(reference: Motion, motion: Motion) -> FloatArray:
    """Return the largest distance of a ball from an exact motion, (k,) [m], at `motion.times`.

    In the plane of the table; the exact motion is taken as it is between its stored states, not
    along chords: balls slow down evenly there, which a cubic with these ends and slopes says to the
    last bit but for rounding.
    """
    if len(reference.times) == 1:  # nothing moves in the exact motion
        return _distances(motion, reference.positions[:, :, :2])
    at, span = reference.times, np.diff(reference.times)
    t = np.minimum(motion.times, at[-1])
    row = np.clip(np.searchsorted(at, t, side="right") - 1, 0, len(span) - 1)
    h = span[row][:, np.newaxis, np.newaxis]
    s = ((t - at[row]) / span[row])[:, np.newaxis, np.newaxis]
    p, v = reference.positions[:, :, :2], reference.velocities[:, :, :2]
    # The state before an event is stored one double earlier, so no span holds a jump but that one.
    with np.errstate(invalid="ignore", over="ignore"):  # where a motion isn't finite
        place = (
            (1.0 + 2.0 * s) * (1.0 - s) ** 2 * p[row]
            + s * (1.0 - s) ** 2 * h * v[row]
            + s**2 * (3.0 - 2.0 * s) * p[row + 1]
            - s**2 * (1.0 - s) * h * v[row + 1]
        )
    return _distances(motion, place)


def _distances(motion: Motion, places: FloatArray) -> FloatArray:
    with np.errstate(invalid="ignore", over="ignore"):  # where a motion isn't finite
        distance: FloatArray = np.linalg.norm(motion.positions[:, :, :2] - places, axis=2).max(
            axis=1
        )
    return distance
