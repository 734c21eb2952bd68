"""Closed forms: the end of a shot, by formula from the scene's exact doubles, to 50 digits.

The code and the arithmetic are independent of the engine. The solver finds the order of collisions
itself, or `FORMS` states the order and the solver checks it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from mpmath import mp, mpf
from numpy.typing import NDArray

from ghostball.model import COLLISION_KINDS, Scene
from ghostball.validation.truth.closed_forms._forms import (
    FORMS,
    MOST_BALLS,
    Form,
    form_of_shape,
)
from ghostball.validation.truth.closed_forms._setup import (
    DIGITS,
    Collision,
    FormResult,
    Key,
    OrderError,
    Vector,
    numbers_of,
    setup_of,
)

__all__ = [
    "DIGITS",
    "FORMS",
    "ClosedForm",
    "closed_form",
    "has_closed_form",
    "may_have_closed_form",
]


SLOWEST = 1e-10
"""Least initial speed [m/s] or angular velocity [rad/s] for a closed form, unless nothing moves.

Values below 1e-40 m/s count as the rounding of 50 digits (`_motion.negligible`).
"""


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """The exact end of a shot, and the effect of rounding its inputs.

    Multiprecision values keep their digits only in arithmetic under `mpmath.workdps(DIGITS)`.

    `rest_positions` [m]: centres in the plane at the end of the run: at rest, or at `t_max`.
    `rest_time` [s]: time at which the last ball came to rest, or `t_max`.
    `final_velocities` [m/s]: zero if the balls came to rest.
    `collision_counts`: by kind, as in `Result.collision_counts`.
    `event_sequence`: the collisions in order of time: kind label, first ball, second ball or
        cushion's name.
    `conditioning` (n,) float64 [m]: for each ball the sum over the scene's numbers x of |d position
        / d x| |x|, and at least |position|: multiplied by 2^-52, it is the error that rounding the
        inputs once would cause.
    `rest_time_conditioning` [s]: the same for the rest time.
    """

    rest_positions: tuple[Vector, ...]
    rest_time: mpf
    final_velocities: tuple[Vector, ...]
    collision_counts: dict[str, int]
    event_sequence: tuple[Collision, ...]
    conditioning: NDArray[np.float64]
    rest_time_conditioning: float


@lru_cache(maxsize=256)  # requested more than once for a scene; many balls take seconds
def closed_form(scene: Scene) -> ClosedForm | None:
    """Return the closed form of `scene`, or None if it has none.

    A scene has a closed form if it is a short sequence of collisions, each between two bodies. Some
    shipped scenes have a form by their name, if their physics and collisions are those of the form.
    """
    solved = _solved(scene)
    if solved is None:
        return None
    form, exact = solved
    with mp.workdps(DIGITS):
        conditioning, rest_time_conditioning = _conditioning(scene, form, numbers_of(scene), exact)
    counts = Counter(kind for kind, _, _ in exact.collisions)
    return ClosedForm(
        exact.positions,
        exact.time,
        exact.velocities,
        {kind.label: counts[kind.label] for kind in COLLISION_KINDS},
        exact.collisions,
        conditioning,
        rest_time_conditioning,
    )


def has_closed_form(scene: Scene) -> bool:
    """Return True if a scene has a closed form; faster, because no conditioning is computed."""
    return _solved(scene) is not None


def may_have_closed_form(scene: Scene) -> bool:
    """Return True if the fields of the scene permit a closed form; nothing is solved.

    `has_closed_form` also checks that the collisions are those of a form.
    """
    return bool(_candidates(scene))


@lru_cache(maxsize=256)
def _solved(scene: Scene) -> tuple[Form, FormResult] | None:
    """Return the form of `scene` and its result, or None if it has none."""
    candidates = _candidates(scene)
    if not candidates:
        return None
    with mp.workdps(DIGITS):
        setup = setup_of(scene, numbers_of(scene), verify=True)
        for candidate in candidates:
            with suppress(OrderError):
                form = candidate or form_of_shape(setup)
                return form, form.solve(setup)
    return None


def _candidates(scene: Scene) -> list[Form | None]:
    """Return the forms that may apply to a scene; None stands for the form by its shape."""
    if not _is_covered(scene):
        return []
    physics = scene.physics
    air = physics.air_drag > 0.0 or physics.rolling_friction_quadratic > 0.0
    found: list[Form | None] = []
    named = FORMS.get(scene.name)
    asked = physics.motion, air, physics.airborne
    if named is not None and (named.motion, named.air, named.flight) == asked:
        found.append(named)
    # The forms by shape are for motion without air or flight.
    if not air and not physics.airborne and len(scene.balls) <= MOST_BALLS:
        found.append(None)
    return found


def _is_covered(scene: Scene) -> bool:
    """Return True if the forms cover the scene's physics and table."""
    physics, table = scene.physics, scene.table
    if table is not None and table.obstacles:
        return False
    fastest = max(np.max(np.abs(scene.velocities)), np.max(np.abs(scene.angular_velocities)))
    if 0.0 < fastest < SLOWEST:
        return False
    cushions = table is not None and bool(table.cushions)
    rubbing = ("frictional", "han2005", "stronge2000")
    rubs = physics.ball_friction != 0.0 or physics.cushion in rubbing
    return (
        (physics.motion == "sliding" or not rubs)
        and (physics.ball_impact == "frictional" or len(scene.balls) == 1)
        and (physics.cushion != "mathavan2010" or not cushions)
        # impacts that last differ from rigid impacts only if a third ball is near
        and (physics.impacts != "compliant" or len(scene.balls) <= 2)
    )


def _conditioning(
    scene: Scene, form: Form, numbers: Mapping[Key, mpf], exact: FormResult
) -> tuple[NDArray[np.float64], float]:
    """Sum |d result / d x| |x| over the scene's numbers, each by one relative nudge of 1e-25."""
    nudge = mp.mpf(10) ** (-DIGITS // 2)
    positions = [mp.mpf(0) for _ in exact.positions]
    time = mp.mpf(0)
    for key, value in numbers.items():
        if value == 0:
            continue
        nudged = {**numbers, key: value * (1 + nudge)}
        moved = form.solve(setup_of(scene, nudged, verify=False))
        for ball, (there, here) in enumerate(zip(moved.positions, exact.positions, strict=True)):
            positions[ball] += mp.hypot(there[0] - here[0], there[1] - here[1]) / nudge
        time += abs(moved.time - exact.time) / nudge
    floors = [mp.hypot(*position) for position in exact.positions]
    return (
        np.array([float(max(pair)) for pair in zip(positions, floors, strict=True)]),
        float(max(time, exact.time)),
    )
