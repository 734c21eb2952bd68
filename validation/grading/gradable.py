"""The part of a certified result that can be compared, and the size of rounding errors.

    >>> within = gradable(scene, certify(scene, motion=True))
    >>> within.extent, within.why, within.until

The part ends at the horizon of the shot, after which rounding decides; at vanishing bounces, which
engines treat as a contact; or at the end of the certified part.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Literal

import numpy as np

from ghostball.model import COLLISION_KINDS, EventKind, ExactTrajectory, Scene
from ghostball.model.arrays import FloatArray
from ghostball.model.scene.obstacles import FIRST_POST
from ghostball.reference_adapters.certified import Certificate
from ghostball.validation.grading.certified_growth import CertifiedGrowth
from ghostball.validation.grading.certified_widths import FlightGrowth, width_sizes
from ghostball.validation.grading.event_logs import events_of_certificate
from ghostball.validation.grading.horizon import Growth, growth_along_certificate, horizon
from ghostball.validation.grading.tolerances import (
    LOWEST_BOUNCE,
    ROUNDINGS,
    TIE,
    TOLERANCE,
    UNIT_ROUNDOFF,
)

_WIDEST = Fraction(1, 2**56)
"""Largest radius of an enclosure, in m or s or relative to its middle: an eighth of a rounding."""

Extent = Literal["whole", "horizon", "low bounce", "certified part"]
"""End of the compared part: the end of the shot, the horizon, the first bounce that is too low for
double precision, or the end of the certified part.
"""


@dataclass(frozen=True, eq=False)
class Gradable:
    """The part of a certified result that engines can be compared with; created by `gradable`.

    `why`: why it isn't the whole shot; else "".
    `until` [s]: last time at which events are compared; inf: the end of the shot.
    `compared_at` [s]: time at which positions are compared: `until`, or earlier if the derivative
        of the certified motion ends earlier; inf: at the end of the shot.
    `sizes` (n,) float64 [m] or None: displacement of each ball by rounding then, over 2^-53;
        infinite without a derivative. None for time-stepping engines, because their errors are
        larger.
    """

    extent: Extent
    why: str
    until: float
    compared_at: float
    sizes: FloatArray | None


def gradable(
    scene: Scene,
    certificate: Certificate,
    *,
    exact: bool = True,
    until: float | None = None,
    growth: Growth | None = None,
) -> Gradable:
    """Return the part of a certified result that can be compared; all exact engines have the same.

    `certificate`: of that scene, with its motion: `certify(scene, motion=True)`.
    `exact`: whether the engines record their motion, not frames.
    `until` [s]: the horizon. Default: time until `ROUNDINGS` roundings at each event have grown to
        `TOLERANCE`.
    `growth`: error growth. Default: along the certified motion.
    """
    if growth is None and (exact or until is None):
        growth = growth_along_certificate(scene, certificate)
    if until is None:
        assert growth is not None
        until = horizon(growth, TOLERANCE, ROUNDINGS * UNIT_ROUNDOFF)
    low_bounce = _first_low_bounce(scene, certificate)
    extent, why, last = _extent(certificate, until, low_bounce)
    narrow = _is_narrow(certificate)
    ends_early = extent == "certified part" and narrow
    # Balls may collide at the time at which a certified part ends; in the run, one rounding
    # earlier.
    at_last = last * (1.0 - TIE) if ends_early else last
    if not exact:
        return Gradable(extent, why, last, at_last, None)
    assert growth is not None
    if ends_early and isinstance(growth, CertifiedGrowth):
        at_last = max(min(at_last, last - _uncertainty_at(growth, scene, last)), 0.0)
    if isinstance(growth, FlightGrowth):
        sizes = width_sizes(certificate)
        if last < float(certificate.t_end):
            sizes[:] = math.inf  # certified widths exist at the end only
        return Gradable(extent, why, last, at_last, sizes)
    compared_at = min(at_last, math.nextafter(growth.derivative_ends, 0.0))
    sizes = growth.sizes([min(compared_at, float(certificate.t_end))])[0]
    if not narrow:
        # The enclosure is wider than a rounding, so errors can't be counted in roundings.
        sizes[:] = math.inf
    return Gradable(extent, why, last, compared_at, sizes)


def _uncertainty_at(growth: CertifiedGrowth, scene: Scene, t: float) -> float:
    """Return the largest shift of the events at a time [s] by `ROUNDINGS` roundings."""
    moved = growth.rounding(scene).events[[event.t == t for event in growth.events]]
    known = moved[np.isfinite(moved)]
    return ROUNDINGS * UNIT_ROUNDOFF * float(np.max(known, initial=0.0))


def motion_of_certificate(scene: Scene, certificate: Certificate) -> ExactTrajectory:
    """Return the motion in a certificate, which must have been made with `motion=True`."""
    motion = certificate.trajectory(scene)
    assert motion is not None
    return motion


def _is_narrow(certificate: Certificate) -> bool:
    """Return True if the final enclosures are narrower than a rounding.

    They may be wider if the computation ran out of time. Then the certified motion, which consists
    of their middles, isn't accurate to rounding.
    """
    numbers = [certificate.t_end, *(one for place in certificate.positions for one in place)]
    return all(one.rad <= _WIDEST * max(abs(one.mid), Fraction(1)) for one in numbers)


def _extent(certificate: Certificate, until: float, low_bounce: float) -> tuple[Extent, str, float]:
    """Return the compared part, why it isn't longer, and its last time."""
    end = float(certificate.t_end)
    if low_bounce <= min(until, end):
        why = f"a bounce stays below {LOWEST_BOUNCE:.2g} diameters until t = {low_bounce:.6g} s"
        return "low bounce", why, math.nextafter(low_bounce, 0.0)
    if until <= end:
        why = f"the horizon is t = {until:.6g} s"
        return "horizon", why, math.nextafter(until, 0.0)
    if not certificate.proved:
        return "certified part", f"{certificate.ending}: {certificate.reason}", end
    return "whole", "", math.inf


@lru_cache(maxsize=4)  # keyed by identity: a case from another process has its own
def _first_low_bounce(scene: Scene, certificate: Certificate) -> float:
    """Return the end of the first bounce that stays below `LOWEST_BOUNCE` [s]; inf if none does.

    A bounce is the motion between two collisions of the same bodies; its height is taken in the
    middle.
    """
    truth = motion_of_certificate(scene, certificate)
    last: dict[tuple[EventKind, int, int], float] = {}
    bounces: list[tuple[EventKind, int, int, float, float]] = []
    for event in events_of_certificate(certificate):
        if event.kind in COLLISION_KINDS:
            if event.key in last:
                bounces.append((*event.key, last[event.key], event.t))
            last[event.key] = event.t
    if not bounces:
        return math.inf
    kinds, a, b, start, end = (np.array(column) for column in zip(*bounces, strict=True))
    # Gaps are in space only if balls may fly; otherwise, heights of balls don't count.
    in_space = scene.physics.airborne
    places = truth.sample(0.5 * (start + end)).positions[:, :, : 3 if in_space else 2]
    rows, radii = np.arange(len(bounces)), scene.radii
    pair = kinds == EventKind.BALL_BALL
    other = np.where(pair, b, a)
    reach = radii[a] + radii[other]
    gaps = np.linalg.norm(places[rows, a] - places[rows, other], axis=1) - reach
    if not pair.all():
        assert scene.table is not None
        across = np.zeros(len(bounces))
        for k in np.flatnonzero(~pair):
            x, y = places[k, a[k], :2].tolist()
            _, across[k] = scene.table.facing(int(b[k]), x, y)
        if in_space:
            above = places[rows, a, 2] - scene.physics.cushion_height
            across = np.hypot(across, np.where(b < FIRST_POST, above, 0.0))  # posts: any height
        across -= radii[a]
        gaps = np.where(pair, gaps, across)
    # Simultaneous collisions are no bounce: a ball pushed against a cushion returns at once.
    low = (gaps <= LOWEST_BOUNCE * reach) & (end > start)
    return float(end[low].min()) if low.any() else math.inf
