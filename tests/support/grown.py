"""Compare the sensitivity and the horizon that a run reports with the certified motion."""

from __future__ import annotations

import math

import numpy as np

from ghostball.model import Result
from ghostball.reference_adapters.certified import Certificate
from ghostball.validation.grading.certified_growth import growth_of_certificate
from ghostball.validation.grading.certified_widths import is_differentiated
from ghostball.validation.grading.horizon import GRID, horizon
from ghostball.validation.grading.tolerances import (
    LARGEST_GROWTH_RATIO,
    ROUNDINGS,
    TOLERANCE,
    UNIT_ROUNDOFF,
)


def self_reported_growth(result: Result, proof: Certificate, until: float = math.inf) -> list[str]:
    """Return a sentence for each reported value that contradicts the certified motion.

    Checked are the horizon and the displacements by rounding, up to the time `until` [s] and to the
    end of the proof. Grades don't use these values, but users do. In a certified flight there is no
    derivative to compare with.
    """
    if float(np.max(np.linalg.norm(result.scene.velocities, axis=1))) < LEAST_SPEED:
        return []
    if not is_differentiated(result.scene):
        return []
    # The engine's own estimate includes rounding of states, but not of gaps.
    growth = growth_of_certificate(result.scene, proof, gaps=False)
    error = ROUNDINGS * UNIT_ROUNDOFF
    end, ends = min(float(proof.t_end), until), growth.derivative_ends
    # If no derivative exists, both report this; after the end of the proof there is no comparison.
    least, said, most = (
        min(known, end, ends)
        for known in (
            horizon(growth, TOLERANCE / LARGEST_GROWTH_RATIO, error),
            result.horizon(TOLERANCE, error),
            horizon(growth, TOLERANCE * LARGEST_GROWTH_RATIO, error),
        )
    )
    faults = []
    if not least - GRID <= said <= most + GRID:
        faults.append(f"`horizon()` is {said:.6g} s, the proved motion's {least:.6g} to {most:.6g}")
    # In the middle of the longest time without events, because the run's events come earlier or
    # later.
    marks = np.append(growth.times[growth.times < most], most)
    longest = int(np.argmax(np.diff(marks, append=most)))
    t = float(np.mean(marks[longest : longest + 2]))
    right, claimed = growth.sizes([t])[0], result.sensitivity([t])[0]
    agree = (claimed <= LARGEST_GROWTH_RATIO * right) & (right <= LARGEST_GROWTH_RATIO * claimed)
    differing = ~agree & (right > 0.0)
    if np.any(differing):
        k = int(np.argmax(differing))
        faults.append(
            f"`sensitivity` of ball {k} at t = {t:.6g} s is {claimed[k]:.4g} m, the proved "
            f"motion's {right[k]:.4g} m"
        )
    return faults


LEAST_SPEED = 2.0**-500
"""Speed [m/s] below which squares underflow, so the engine's tangent map has no derivative."""
