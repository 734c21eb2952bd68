"""What of a proof engines can be graded against: up to where, and how far rounding goes by then.

    >>> within = gradable(scene, certify(scene, motion=True))
    >>> within.extent, within.why, within.until

Up to the predictability horizon of the shot, since after it rounding alone decides; up to where
bounces die out, which the model that is graded takes for a contact; and up to where the proof ends.
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
from ghostball.validation.grading.event_logs import proved_events
from ghostball.validation.grading.horizon import Growth, growth_along_proof, horizon
from ghostball.validation.grading.tolerances import (
    LOWEST_BOUNCE,
    ROUNDINGS,
    TIE,
    TOLERANCE,
    UNIT_ROUNDOFF,
)

_WIDEST = Fraction(1, 2**56)
"""Radius of an enclosure, in m or s, or of its middle: an eighth of a rounding."""

Extent = Literal["whole", "horizon", "low bounce", "proved part"]
"""Up to where events are graded: the end, the predictability horizon, the first bounce that is too
low to be followed in double precision, or the proof's end."""


@dataclass(frozen=True, eq=False)
class Gradable:
    """What of a proof engines can be graded against; made by `gradable`.

    `why`: where it isn't the whole shot, why not; else "".
    `until` [s]: the last instant at which events are graded; inf where that is the end of the shot.
    `compared_at` [s]: when positions are compared: at that instant, or before it, where the
        derivative of the proved motion ends sooner; inf: at the end of the shot.
    `sizes` (n,) float64 [m] or None: what rounding does to each ball until then, over 2^-53:
        infinite where no derivative says it. None for engines that step, whose errors hide those of
        rounding.
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
    """Return what of a proof can be graded, which is the same for all exact engines.

    `certificate`: of that scene, with its motion: `certify(scene, motion=True)`.
    `exact`: whether for engines that record their motion, not frames.
    `until` [s]: the horizon: up to when the shot can be predicted. Left out: until `ROUNDINGS`
        roundings at each event have grown to `TOLERANCE`.
    `growth`: how errors grow. Left out: as along the proved motion.
    """
    if growth is None and (exact or until is None):
        growth = growth_along_proof(scene, certificate)
    if until is None:
        assert growth is not None
        until = horizon(growth, TOLERANCE, ROUNDINGS * UNIT_ROUNDOFF)
    low_bounce = _first_low_bounce(scene, certificate)
    extent, why, last = _extent(certificate, until, low_bounce)
    narrow = _is_narrow(certificate)
    ends_early = extent == "proved part" and narrow
    # Balls may meet at the instant at which a proof ends; in the run, one rounding earlier.
    at_last = last * (1.0 - TIE) if ends_early else last
    if not exact:
        return Gradable(extent, why, last, at_last, None)
    assert growth is not None
    if ends_early and isinstance(growth, CertifiedGrowth):
        at_last = max(min(at_last, last - _uncertainty_at(growth, scene, last)), 0.0)
    if isinstance(growth, FlightGrowth):
        sizes = width_sizes(certificate)
        if last < float(certificate.t_end):
            sizes[:] = math.inf  # the proof has widths of its end alone
        return Gradable(extent, why, last, at_last, sizes)
    compared_at = min(at_last, math.nextafter(growth.derivative_ends, 0.0))
    sizes = growth.sizes([min(compared_at, float(certificate.t_end))])[0]
    if not narrow:
        # The proof is wider than a rounding, so errors can't be counted in roundings.
        sizes[:] = math.inf
    return Gradable(extent, why, last, compared_at, sizes)


def _uncertainty_at(growth: CertifiedGrowth, scene: Scene, t: float) -> float:
    """Return how far `ROUNDINGS` roundings move the events at an instant [s], the most of them."""
    moved = growth.rounding(scene).events[[event.t == t for event in growth.events]]
    known = moved[np.isfinite(moved)]
    return ROUNDINGS * UNIT_ROUNDOFF * float(np.max(known, initial=0.0))


def proved_motion(scene: Scene, certificate: Certificate) -> ExactTrajectory:
    """Return the motion that a certificate of a scene holds: it was made with `motion=True`."""
    motion = certificate.trajectory(scene)
    assert motion is not None
    return motion


def _is_narrow(certificate: Certificate) -> bool:
    """Whether a proof encloses its end to less than a rounding; one that ran out of time may not.

    Then the middles of its enclosures, which its motion is made of, say nothing.
    """
    numbers = [certificate.t_end, *(one for place in certificate.positions for one in place)]
    return all(one.rad <= _WIDEST * max(abs(one.mid), Fraction(1)) for one in numbers)


def _extent(certificate: Certificate, until: float, low_bounce: float) -> tuple[Extent, str, float]:
    """Return how much is graded, why not more, and the last instant of it."""
    end = float(certificate.t_end)
    if low_bounce <= min(until, end):
        why = f"a bounce stays below {LOWEST_BOUNCE:.2g} diameters until t = {low_bounce:.6g} s"
        return "low bounce", why, math.nextafter(low_bounce, 0.0)
    if until <= end:
        why = f"the horizon is t = {until:.6g} s"
        return "horizon", why, math.nextafter(until, 0.0)
    if not certificate.proved:
        return "proved part", f"{certificate.ending}: {certificate.reason}", end
    return "whole", "", math.inf


@lru_cache(maxsize=4)  # by identity: a case that comes from another process has its own
def _first_low_bounce(scene: Scene, certificate: Certificate) -> float:
    """Return when the first bounce ends that stays below `LOWEST_BOUNCE`, inf where none does [s].

    A bounce is what is between two collisions of one contact; its height is taken in the middle.
    """
    truth = proved_motion(scene, certificate)
    last: dict[tuple[EventKind, int, int], float] = {}
    bounces: list[tuple[EventKind, int, int, float, float]] = []
    for event in proved_events(certificate):
        if event.kind in COLLISION_KINDS:
            if event.key in last:
                bounces.append((*event.key, last[event.key], event.t))
            last[event.key] = event.t
    if not bounces:
        return math.inf
    kinds, a, b, start, end = (np.array(column) for column in zip(*bounces, strict=True))
    # In space where balls may fly; else those of different size are taken to be at one height.
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
            across = np.hypot(across, np.where(b < FIRST_POST, above, 0.0))  # a post is as tall
        across -= radii[a]
        gaps = np.where(pair, gaps, across)
    # Collisions at one instant are no bounce: what is struck against a cushion comes back at once.
    low = (gaps <= LOWEST_BOUNCE * reach) & (end > start)
    return float(end[low].min()) if low.any() else math.inf
