"""Until when an engine can be expected to play a shot as it is: its predictability horizon.

Errors grow along a shot by its tangent map: of the proved motion where the whole shot is proved, so
that no engine says itself how far it is judged; else of our engine's. An engine makes errors of
its own size: an exact one those of rounding, one that steps those of a contact seen up to a step
late. Once these may have made another ball meet, or first, or have grown to the radius of a ball
that is about to meet another, the shot may take another course, and what comes after says nothing
of the engine any more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import EventKind, Result, Scene
from ghostball.reference_adapters.certified import Certificate
from ghostball.validation.grading.certified_growth import CertifiedGrowth
from ghostball.validation.grading.certified_widths import hit_widths
from ghostball.validation.grading.tolerances import ROUNDINGS, UNIT_ROUNDOFF
from ghostball.validation.runs.sampling import events_of
from ghostball.validation.truth.bifurcations import bifurcations_of, directions_of, extent_of

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Growth:
    """How errors grow along a shot until two balls meet, by its tangent map.

    Attributes
    ----------
    times : (k,) float64 [s]
        Of the collisions of two balls.
    largest : (k,) float64 [m]
        What a relative error of 1 at the start and at each event has become of the two just before
        (`CertifiedGrowth.sizes`, `Result.sensitivity`); inf where no derivative exists.
    course_times : (m,) float64 [s]
    course_changes : (m,) float64 [1]
        Where the shot passes a bifurcation, and what relative change of the first state would have
        taken it another course there (`validation.truth.bifurcations.bifurcations_of`).
    extent : float [m]
        Of the scene: what a relative error is relative to.
    radius : float [m]
        Of the smallest ball.
    """

    times: FloatArray
    largest: FloatArray
    course_times: FloatArray
    course_changes: FloatArray
    extent: float
    radius: float

    def horizon(self, resolution: float) -> float:
        """Return when errors may first have changed the course of the shot [s]; inf: never.

        Parameters
        ----------
        resolution : float [m]
            Of the engine: how far off a ball may be when it collides. Rounding comes on top.
        """
        error = max(ROUNDINGS * UNIT_ROUNDOFF, resolution / self.extent)
        grown = self.times[~(error * self.largest <= self.radius)]
        turned = self.course_times[self.course_changes <= error]
        return float(min(np.min(grown, initial=np.inf), np.min(turned, initial=np.inf)))


def growth_of_flight(scene: Scene, certificate: Certificate) -> Growth:
    """Return how errors grow at most along a proved flight, by the widths of its enclosures.

    Which bifurcations it passes isn't known: no derivative says how far off they are.
    """
    times, largest = hit_widths(scene, certificate)
    none, radius = np.empty(0), float(np.min(scene.radii))
    return Growth(times, largest, none, none, extent_of(scene), radius)


def growth_of(result: Result, proved: CertifiedGrowth | None = None) -> Growth:
    """Measure how errors grow along a shot, recorded with its motion.

    By what `proved` says of it, where that is given; else by the shot's own tangent map.
    """
    scene, events = result.scene, events_of(result)
    hits = events[events["kind"] == EventKind.BALL_BALL]
    times = hits["t"].astype(np.float64)
    largest = np.zeros(len(times))
    if len(times):
        sizes = result.sensitivity if proved is None else proved.sizes
        growth, rows = sizes(np.nextafter(times, 0.0)), np.arange(len(times))
        largest = np.maximum(growth[rows, hits["a"]], growth[rows, hits["b"]])
    changes = None if proved is None else proved.carry(directions_of(scene))
    courses = [(one.t, one.relative) for one in bifurcations_of(result, changes)]
    course_times, course_changes = np.array(courses).reshape(-1, 2).T
    return Growth(
        times, largest, course_times, course_changes, extent_of(scene), float(np.min(scene.radii))
    )
