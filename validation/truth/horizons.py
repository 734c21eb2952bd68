"""Until when an engine can be expected to play a shot as it is: its predictability horizon.

Errors grow along a shot by its tangent map: of the proved motion where the whole shot is proved, so
that no engine says itself how far it is judged; else of our engine's. An engine makes errors of
its own size: an exact one those of rounding, one that steps those of a contact seen up to a step
late. Once these have grown to the radius of a ball that is about to meet another, the shot may take
another course, and what comes after says nothing of the engine any more. How near the shot comes to
another course is no part of it: who takes that one before then plays another shot.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import EventKind, Result, Scene
from ghostball.reference_adapters.certified import Certificate
from ghostball.validation.grading.certified_growth import CertifiedGrowth, growth_of_proof
from ghostball.validation.grading.certified_widths import (
    hit_widths,
    is_differentiated,
    width_horizon,
)
from ghostball.validation.grading.tolerances import ROUNDINGS, TOLERANCE, UNIT_ROUNDOFF
from ghostball.validation.runs.our_run import run_ours
from ghostball.validation.runs.sampling import events_of
from ghostball.validation.truth.proof import proof_of

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
    extent : float [m]
        Of the scene: what a relative error is relative to.
    radius : float [m]
        Of the smallest ball.
    """

    times: FloatArray
    largest: FloatArray
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
        return float(np.min(grown, initial=np.inf))


def extent_of(scene: Scene) -> float:
    """Return the largest coordinate of a scene, of its table or of a ball [m]."""
    extent = float(np.max(np.abs(scene.positions[:, :2])) + np.max(scene.radii))
    return extent if scene.table is None else max(extent, scene.table.length, scene.table.width)


def rounding_horizon(
    scene: Scene, tolerance: float = TOLERANCE, error: float = ROUNDINGS * UNIT_ROUNDOFF
) -> float:
    """Return until when errors of rounding leave a shot predictable [s]; inf: to its end.

    Along the proved motion, where the whole shot is proved; else along our engine's.

    Parameters
    ----------
    scene : Scene
    tolerance : float [m]
        How far they may displace a ball.
    error : float
        Relative size of the error that is made at the start and at each event.

    Raises
    ------
    UnsupportedSceneError
        Where neither a proof nor our engine represents the scene.
    """
    proof, _ = proof_of(scene)
    if proof is None or not proof.proved:
        return run_ours(scene).horizon(tolerance, error)
    if is_differentiated(scene):
        return growth_of_proof(scene, proof).horizon(tolerance, error)
    return width_horizon(scene, proof, tolerance, error)


def growth_of_flight(scene: Scene, certificate: Certificate) -> Growth:
    """Return how errors grow at most along a proved flight, by the widths of its enclosures."""
    return Growth(*hit_widths(scene, certificate), extent_of(scene), float(np.min(scene.radii)))


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
    return Growth(times, largest, extent_of(scene), float(np.min(scene.radii)))
