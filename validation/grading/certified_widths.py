"""How errors grow along a proved flight: by the widths of the proof's own enclosures.

Along a flight no derivative is followed. But a proof in p bits carries what rounding every number
to p bits may do, at its worst: in doubles the same enclosures would be 2^(p - 53) times as wide. So
they bound what an engine's rounding may do, from above, where `certified_growth` says what it does
on average.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import EventKind, Scene
from ghostball.reference_adapters.certified import Certificate, Enclosure
from ghostball.reference_adapters.certified.problem import problem_of
from ghostball.reference_adapters.certified.run import largest_speeds
from ghostball.validation.grading.tolerances import ROUNDINGS, TOLERANCE, UNIT_ROUNDOFF

FloatArray = NDArray[np.float64]

_LARGEST = 10**300
"""Beyond it a width is as good as infinite."""


def is_differentiated(scene: Scene) -> bool:
    """Whether `certified_growth` follows how errors grow along the proved motion of a scene."""
    return not scene.physics.airborne


def width_horizon(
    scene: Scene,
    certificate: Certificate,
    tolerance: float = TOLERANCE,
    error: float = ROUNDINGS * UNIT_ROUNDOFF,
) -> float:
    """Return the first event whose instant errors of rounding may move by too much [s]; or inf.

    That is, by so much that the fastest ball goes further than the tolerance [m] meanwhile.
    """
    fastest = max(largest_speeds(problem_of(scene))) * error / UNIT_ROUNDOFF
    for event in certificate.events:
        if not _in_doubles(event.t, certificate) * fastest <= tolerance:
            return float(event.t)
    return math.inf


def hit_widths(scene: Scene, certificate: Certificate) -> tuple[FloatArray, FloatArray]:
    """Return when two balls meet [s], and how far rounding may displace them by then, over 2^-53.

    That is, how far the fastest ball goes while their meeting is uncertain [m]; (k,) each.
    """
    fastest = max(largest_speeds(problem_of(scene)))
    hits = [event.t for event in certificate.events if event.kind is EventKind.BALL_BALL]
    sizes = [_in_doubles(t, certificate) * fastest / UNIT_ROUNDOFF for t in hits]
    return np.array([float(t) for t in hits]), np.array(sizes)


def width_sizes(certificate: Certificate) -> FloatArray:
    """Return how far rounding may displace each ball at the proof's end, over 2^-53: (n,) [m].

    A ball that no event concerns isn't displaced; that of another is rounded itself, too.
    """
    moved = {event.a for event in certificate.events}
    moved |= {event.b for event in certificate.events if event.kind is EventKind.BALL_BALL}
    sizes = np.zeros(len(certificate.positions))
    for k, place in enumerate(certificate.positions):
        widths = [_in_doubles(x, certificate) / UNIT_ROUNDOFF for x in place]
        if k in moved or any(widths):
            sizes[k] = math.hypot(*widths) + math.hypot(*map(float, place))
    return sizes


def _in_doubles(value: Enclosure, certificate: Certificate) -> float:
    """Return the radius that an enclosure would have if it were computed in double precision."""
    wide = value.rad * Fraction(2) ** (certificate.precision - 53)
    return float(wide) if wide < _LARGEST else math.inf
