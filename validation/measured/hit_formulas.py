"""Closed forms of hits, and the uncertainty that their measured inputs give their results."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from ghostball.model.arrays import FloatArray

_STICKING: Final = 2.0 / 7.0
"""Impulse over the reduced mass, per slip, that ends the slip of two solid spheres."""

_SMALL_STEP: Final = 1e-3
"""Step of a finite difference, in standard errors of an input."""


def directions_after_hit(restitution: float, friction: float, cut: float) -> FloatArray:
    """Return the direction of the cue ball and the throw of the object ball, (2,) [degrees].

    A rolling cue ball hits an equal ball at rest at a cut [degrees]. Both values are those when
    both balls roll: the direction is measured from the path before, the throw from the line of
    centres at the hit, towards that path.

    First the impact: the normal impulse is (1 + e) times the approach speed, and friction is mu
    times the normal impulse, at most the impulse that ends the slip (Wallace and Schroeder 1988).
    Then the slide, which ends with 5/7 v + 2/7 R w x k (Coriolis 1835). Domenech 2008 has the same
    two steps. No result depends on the speed, on the radius, or on the friction of the cloth.
    """
    sine, cosine = math.sin(math.radians(cut)), math.cos(math.radians(cut))
    normal, along = np.array([cosine, -sine, 0.0]), np.array([sine, cosine, 0.0])
    up = np.array([0.0, 0.0, 1.0])
    # Speeds in units of the approach of the cue ball, the radius is 1. Its surface slips by (sine)
    # along, and by (cosine) downwards because it rolls: by 1 in all.
    part = min(friction * (1.0 + restitution) * cosine, _STICKING)
    impulse = 0.5 * ((1.0 + restitution) * cosine * normal + part * (sine * along - cosine * up))
    turn = -2.5 * np.cross(normal, impulse)  # of both balls, moment of inertia 2/5
    cue, cue_spin = np.array([1.0, 0.0, 0.0]) - impulse, np.array([0.0, 1.0, 0.0]) + turn
    cue, other = (
        5.0 / 7.0 * speed * (1.0, 1.0, 0.0) + 2.0 / 7.0 * np.cross(spin * (1.0, 1.0, 0.0), up)
        for speed, spin in ((cue, cue_spin), (impulse, turn))
    )
    cue_angle, other_angle = (math.degrees(math.atan2(v[1], v[0])) for v in (cue, other))
    return np.array([cue_angle, cut + other_angle])


def speeds_after_head_on_hit(restitution: float, mass_ratio: float) -> FloatArray:
    """Return the speeds of the hitting ball and of the other right after a head-on hit, (2,).

    They are over the speed before; `mass_ratio` is the mass of the hitting ball over the other's.
    """
    whole = 1.0 + mass_ratio
    speeds = [(mass_ratio - restitution) / whole, mass_ratio * (1.0 + restitution) / whole]
    return np.array(speeds)


def uncertainty(
    formula: Callable[..., FloatArray], inputs: Sequence[float], errors: Sequence[float]
) -> FloatArray:
    """Return the standard errors of the results of a formula, with the shape of its results.

    `inputs` have independent standard `errors`, which are carried through by central differences
    (ASME V&V 20, u_input; JCGM 100, 5.1.2).
    """
    changes = []
    for step in np.diag(_SMALL_STEP * np.array(errors)):
        ends = (formula(*(np.array(inputs) + sign * step)) for sign in (1.0, -1.0))
        changes.append(np.subtract(*ends) / (2.0 * _SMALL_STEP))
    carried: FloatArray = np.linalg.norm(changes, axis=0)
    return carried
