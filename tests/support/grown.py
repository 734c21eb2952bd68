"""What a run says of its own predictability, held against the proof of its shot."""

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
    """Return what a run says of its own predictability that the proved motion contradicts.

    Its horizon, and how far rounding displaces its balls; as far as the shot is proved, and up to
    an instant `until` [s]. No grade depends on them, but users do. Along a proved flight the
    grader follows no derivative.
    """
    if float(np.max(np.linalg.norm(result.scene.velocities, axis=1))) < LEAST_SPEED:
        return []
    if not is_differentiated(result.scene):
        return []
    # Our engine's own estimate rounds states only, not gaps.
    growth = growth_of_certificate(result.scene, proof, gaps=False)
    error = ROUNDINGS * UNIT_ROUNDOFF
    end, ends = min(float(proof.t_end), until), growth.derivative_ends
    # Where no derivative exists both say so, and beyond the proof the grader says nothing.
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
    # Amid the longest time without an event, for the run's own events come sooner or later.
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
"""Speed [m/s] below which squares vanish, and our engine's map says that there is no derivative."""
