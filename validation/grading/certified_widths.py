"""How errors grow along a proved flight: by the widths of the proof's own enclosures.

Along a flight no derivative is followed. But a proof in p bits carries what rounding every number
to p bits may do, at its worst: in doubles the same enclosures would be 2^(p - 53) times as wide. So
they bound what an engine's rounding may do, from above, where `certified_growth` says what it does
on average.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import Scene
from ghostball.reference_adapters.certified import Certificate
from ghostball.reference_adapters.certified.problem import problem_of
from ghostball.reference_adapters.certified.run import largest_speeds
from ghostball.validation.grading.tolerances import ROUNDINGS, TOLERANCE, UNIT_ROUNDOFF

FloatArray = NDArray[np.float64]


def is_differentiated(scene: Scene) -> bool:
    """Whether `certified_growth` follows how errors grow along the proved motion of a scene."""
    return not scene.physics.airborne


def width_horizon(scene: Scene, certificate: Certificate) -> float:
    """Return the first event whose instant `ROUNDINGS` roundings may move by too much [s]; or inf.

    That is, by so much that the fastest ball goes further than `TOLERANCE` meanwhile.
    """
    fastest = max(largest_speeds(problem_of(scene)))
    scale = _in_doubles(certificate) * ROUNDINGS * fastest
    for event in certificate.events:
        if not float(event.t.rad) * scale <= TOLERANCE:
            return float(event.t)
    return math.inf


def width_sizes(certificate: Certificate) -> FloatArray:
    """Return how far rounding may displace each ball at the proof's end, over 2^-53: (n,) [m].

    A ball whose place is exact is displaced by nothing; that of another is rounded itself, too.
    """
    scale = _in_doubles(certificate) / UNIT_ROUNDOFF
    sizes = np.zeros(len(certificate.positions))
    for k, place in enumerate(certificate.positions):
        widths = [float(x.rad) * scale for x in place]
        if any(widths):
            sizes[k] = math.hypot(*widths) + math.hypot(*map(float, place))
    return sizes


def _in_doubles(certificate: Certificate) -> float:
    """Return how many times as wide a proof's enclosures would be in double precision."""
    return UNIT_ROUNDOFF * 2.0**certificate.precision
