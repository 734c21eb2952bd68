"""Closed forms: for short shots by their collisions, for other shipped scenes by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from typing import Literal, NamedTuple

from mpmath import mpf

from ghostball.validation.truth.closed_forms._alone import (
    alone_in_air,
    alone_in_flight,
    fall_in_air,
)
from ghostball.validation.truth.closed_forms._contacts import (
    collision_with_two,
    pushed_along,
    wedged,
)
from ghostball.validation.truth.closed_forms._motion import make_sure_apart
from ghostball.validation.truth.closed_forms._setup import (
    Collision,
    FormResult,
    OrderError,
    Setup,
    Vector,
)
from ghostball.validation.truth.closed_forms._shot import OrderedShot
from ghostball.validation.truth.closed_forms._unfolding import unfolded_bounces, unfolded_masses


class Form(NamedTuple):
    """A solver of a scene, and its kind of motion: rolling or sliding, air, flight."""

    solve: Callable[[Setup], FormResult]
    motion: Literal["rolling", "sliding"] = "rolling"
    air: bool = False
    flight: bool = False


def _in_order(order: Sequence[Collision], setup: Setup) -> FormResult:
    shot = OrderedShot(setup)
    for collision in order:
        shot.play(collision)
    return shot.end()


_squeezed_out = partial(
    _in_order, [("ball-ball", 0, 1), ("ball-cushion", 1, "left"), ("ball-ball", 0, 1)]
)
"""The first ball hits the second, which lies on the left cushion, bounces, and hits back."""


def _chain(setup: Setup) -> FormResult:
    """Solve a line in which each ball hits the next, after rolling through the gap or touching it.

    For touching balls, one impact follows the other, as with vanishing gaps.
    """
    line = range(len(setup.positions) - 1)
    return _in_order([("ball-ball", ball, ball + 1) for ball in line], setup)


class _Pair(NamedTuple):
    """Two balls that collide once: the time, their end, and points around their paths."""

    contact: mpf
    outcome: FormResult
    hull: list[Vector]


def _separate_pairs(setup: Setup) -> FormResult:
    """Solve many shots on one cloth: balls 0 and 1, balls 2 and 3, ...; each pair collides once.

    The boxes around the paths of the pairs are disjoint, so each pair is a separate shot.
    """
    n = len(setup.positions)
    if n % 2 or setup.cushions:
        raise OrderError("needs pairs of balls on an unbounded cloth")
    setups = [setup.of(slice(first, first + 2)) for first in range(0, n, 2)]
    pairs = [_solve_pair(pair) for pair in setups]
    if setup.verify:
        make_sure_apart([pair.hull for pair in pairs], [max(pair.radii) for pair in setups])
    order = sorted(range(len(pairs)), key=lambda k: pairs[k].contact)
    return FormResult(
        tuple(position for pair in pairs for position in pair.outcome.positions),
        tuple(velocity for pair in pairs for velocity in pair.outcome.velocities),
        max(pair.outcome.time for pair in pairs),
        tuple(("ball-ball", 2 * k, 2 * k + 1) for k in order),
    )


# Most nudges for the conditioning change one pair only; the other pairs come from the cache.
@lru_cache(maxsize=256)
def _solve_pair(setup: Setup) -> _Pair:
    shot = OrderedShot(setup)
    shot.play(("ball-ball", 0, 1))
    return _Pair(shot.time, shot.end(), shot.hull)


MOST_BALLS, MOST_COLLISIONS = 3, 6
"""Limits for scenes that are solved by shape: each collision loses digits."""


def form_of_shape(setup: Setup) -> Form:
    """Return the form of a shot with a few consecutive collisions, each between two bodies.

    Raises `OrderError` if the shot isn't of this kind.
    """
    shot = OrderedShot(setup)
    while (found := shot.next_collision()) is not None:
        if len(shot.collisions) == MOST_COLLISIONS:
            raise OrderError("more collisions than are solved by shape")
        shot.play(found)
    return Form(
        partial(_in_order, tuple(shot.collisions)), "sliding" if setup.slides else "rolling"
    )


_PAIRS = "thirty-degree-rule", "throw-by-angle", "throw-by-spin"
_ROLLING_IN_AIR = "air-paper", "air-drag", "cloth-quadratic"
_SLIDING_IN_AIR = "air-rolls", "air-drag-sliding", "cloth-quadratic-sliding", "air-slides"
_MIRRORED = "wall-bounce", "corner-double-bounce", "corner-exact", "around-the-table", "rail-into"

FORMS: Mapping[str, Form] = {
    **dict.fromkeys(_MIRRORED, Form(unfolded_bounces)),
    **dict.fromkeys((f"galperin-{k}" for k in range(4)), Form(unfolded_masses)),
    "cradle": Form(_chain),
    "three-ball-symmetric": Form(collision_with_two),
    "frozen-to-cushion": Form(_squeezed_out),
    **dict.fromkeys(_PAIRS, Form(_separate_pairs, motion="sliding")),
    "push": Form(pushed_along, motion="sliding"),
    "push-unequal": Form(pushed_along, motion="sliding"),
    "wedged": Form(wedged, motion="sliding"),
    **dict.fromkeys(_ROLLING_IN_AIR, Form(alone_in_air, air=True)),
    **dict.fromkeys(_SLIDING_IN_AIR, Form(alone_in_air, motion="sliding", air=True)),
    "air-drop": Form(fall_in_air, motion="sliding", air=True, flight=True),
    **dict.fromkeys(
        ("flight-throw", "flight-lands", "flight-bounces"),
        Form(alone_in_flight, motion="sliding", flight=True),
    ),
}
"""Solvers by scene name, for scenes without a form by their shape; see `closed_form`."""
