"""Error growth along a certified flight, from the widths of the certified enclosures.

No derivative is computed along a flight. But a certified computation with p bits propagates the
worst effect of rounding every number to p bits; in doubles, the same enclosures would be 2^(p - 53)
times as wide. The widths are therefore upper bounds on the effect of an engine's rounding, whereas
`certified_growth` gives its average effect.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from ghostball.model import Scene, first_energy
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.certified import Certificate, Enclosure
from ghostball.reference_adapters.certified.order import largest_speeds
from ghostball.reference_adapters.certified.problem import problem_of
from ghostball.validation.grading.certified_growth import RoundingEffects, places_between
from ghostball.validation.grading.event_logs import events_of_certificate
from ghostball.validation.grading.tolerances import UNIT_ROUNDOFF

_LARGEST = 10**300
"""Widths above this count as infinite."""


def is_differentiated(scene: Scene) -> bool:
    """Return True if `certified_growth` computes the error growth of a scene."""
    return not scene.physics.airborne


class FlightGrowth:
    """Upper bounds on error growth along a certified flight, as a `horizon.Growth`."""

    derivative_ends = math.inf

    def __init__(self, scene: Scene, certificate: Certificate) -> None:
        self.t_end = float(certificate.t_end)
        events = events_of_certificate(certificate)
        self.times: FloatArray = np.unique([0.0, *(event.t for event in events)])
        fastest = max(largest_speeds(problem_of(scene)))
        self._events: list[list[tuple[float, float]]] = [[(0.0, 0.0)] for _ in scene.balls]
        self._moved: list[float] = []
        self._end = max(_in_doubles(certificate.t_end, certificate) / UNIT_ROUNDOFF, self.t_end)
        for event, certified in zip(events, certificate.events, strict=True):
            moved = _in_doubles(certified.t, certificate) / UNIT_ROUNDOFF
            self._moved.append(max(moved, event.t))
            width = moved * fastest
            for ball in event.balls:
                self._events[ball].append((event.t, width))

    def sizes(self, times: ArrayLike) -> FloatArray:
        """Return how far the fastest ball moves within the uncertainty of each ball's last event.

        The uncertainty is that of a certified computation in double precision. Values are divided
        by 2^-53: (k, n) [m].
        """
        t = np.atleast_1d(np.asarray(times, dtype=np.float64))
        sizes = np.empty((len(t), len(self._events)))
        for ball, events in enumerate(self._events):
            instants, widths = np.array(events).T
            sizes[:, ball] = widths[np.searchsorted(instants, t, side="right") - 1]
        return sizes

    def rounding(self, scene: Scene) -> RoundingEffects:
        """Return upper bounds on the effects of rounding on the times of events and on the energy.

        If a ball is displaced by a distance s when it collides, the line of centres turns by at
        most s / 2R, and the exchanged energy changes in proportion.
        """
        at = np.append(0.0, self.times)
        first = first_energy(scene)
        beside = np.maximum.accumulate(np.max(self.sizes(at), axis=1))
        energies = first * (1.0 + beside / float(np.min(scene.radii)))
        events = np.array(self._moved)
        marks, places = places_between(self.sizes, self.times, self.t_end)
        unknown = np.full_like(places, np.inf)  # widths exist for positions only
        return RoundingEffects(events, self._end, at, energies, marks, places, unknown)


def width_sizes(certificate: Certificate) -> FloatArray:
    """Return the possible displacement of each ball by rounding at the certified end: (n,) [m].

    The values are divided by 2^-53. A ball at rest without events isn't displaced. For other balls,
    the rounding of the coordinates is added.
    """
    moved = {ball for event in events_of_certificate(certificate) for ball in event.balls}
    moved |= {k for k, v in enumerate(certificate.velocities) if any(map(float, v))}
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
