"""The closed form of each shipped scene that has one, by its name; of any other by its shape."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from typing import Literal, NamedTuple

from mpmath import mpf

from ghostball.validation.truth.closed_forms._air import alone_in_air
from ghostball.validation.truth.closed_forms._contacts import (
    collision_with_two,
    pushed_along,
    wedged,
)
from ghostball.validation.truth.closed_forms._falls import fall_in_air
from ghostball.validation.truth.closed_forms._flight import alone_in_flight
from ghostball.validation.truth.closed_forms._motion import make_sure_apart
from ghostball.validation.truth.closed_forms._setup import (
    Collision,
    OrderError,
    Outcome,
    Setup,
    Vector,
)
from ghostball.validation.truth.closed_forms._shot import Shot
from ghostball.validation.truth.closed_forms._unfolding import unfolded_bounces, unfolded_masses


class Form(NamedTuple):
    """How to solve a scene, and which motion the solution is for: in air, or off the cloth, too."""

    solve: Callable[[Setup], Outcome]
    motion: Literal["rolling", "sliding"] = "rolling"
    air: bool = False
    flight: bool = False


def _in_order(order: Sequence[Collision], setup: Setup) -> Outcome:
    shot = Shot(setup)
    for collision in order:
        shot.play(collision)
    return shot.end()


_undisturbed = partial(_in_order, ())
"""Balls that meet nothing: each slides, rolls v^2 / (2 mu g) and rests."""

_one_collision = partial(_in_order, [("ball-ball", 0, 1)])

_collision_of_the_last = partial(_in_order, [("ball-ball", 0, 2)])
"""The first ball passes the second and hits the third."""

_bounce_right = partial(_in_order, [("ball-cushion", 0, "right")])

_squeezed_out = partial(
    _in_order, [("ball-ball", 0, 1), ("ball-cushion", 1, "left"), ("ball-ball", 0, 1)]
)
"""The first ball hits the second, which lies on the left cushion, bounces, and hits back."""


def _chain(setup: Setup) -> Outcome:
    """Let each ball of a line hit the next: it rolls through the gap, or touches it all the time.

    Of balls that touch, one impact comes after the other, as with gaps that vanish.
    """
    line = range(len(setup.positions) - 1)
    return _in_order([("ball-ball", ball, ball + 1) for ball in line], setup)


class _Pair(NamedTuple):
    """Two balls that collide once: when, how they end, and points whose hull holds their paths."""

    contact: mpf
    outcome: Outcome
    hull: list[Vector]


def _separate_pairs(setup: Setup) -> Outcome:
    """Many shots on one cloth: balls 0 and 1, balls 2 and 3, ... each pair collides once.

    No pair comes into the box around another's paths, so that each is a shot of its own.
    """
    n = len(setup.positions)
    if n % 2 or setup.cushions:
        raise OrderError("needs pairs of balls on an unbounded cloth")
    setups = [setup.of(slice(first, first + 2)) for first in range(0, n, 2)]
    pairs = [_solve_pair(pair) for pair in setups]
    if setup.verify:
        make_sure_apart([pair.hull for pair in pairs], [max(pair.radii) for pair in setups])
    order = sorted(range(len(pairs)), key=lambda k: pairs[k].contact)
    return Outcome(
        tuple(position for pair in pairs for position in pair.outcome.positions),
        tuple(velocity for pair in pairs for velocity in pair.outcome.velocities),
        max(pair.outcome.time for pair in pairs),
        tuple(("ball-ball", 2 * k, 2 * k + 1) for k in order),
    )


@lru_cache(maxsize=256)  # a nudge for the conditioning changes one pair, or all by one number
def _solve_pair(setup: Setup) -> _Pair:
    shot = Shot(setup)
    shot.play(("ball-ball", 0, 1))
    return _Pair(shot.time, shot.end(), shot.hull)


MOST_BALLS, MOST_COLLISIONS = 3, 6
"""What a scene may have that is solved by its shape: more digits are lost with every collision."""


def form_of_shape(setup: Setup) -> Form:
    """Return the form of a shot of a few collisions, one after the other, each of two alone.

    Raises `OrderError` where it is none.
    """
    if len(setup.positions) > MOST_BALLS:
        raise OrderError("more balls than are solved by shape")
    shot = Shot(setup)
    while (found := shot.next_collision()) is not None:
        if len(shot.collisions) == MOST_COLLISIONS:
            raise OrderError("more collisions than are solved by shape")
        shot.play(found)
    return Form(
        partial(_in_order, tuple(shot.collisions)), "sliding" if setup.slides else "rolling"
    )


FORMS: Mapping[str, Form] = {
    "stop": Form(_undisturbed),
    "roll-distance": Form(_undisturbed),
    "wall-bounce": Form(unfolded_bounces),
    "corner-double-bounce": Form(unfolded_bounces),
    "corner-exact": Form(unfolded_bounces),
    "around-the-table": Form(unfolded_bounces),
    "rail-along": Form(_undisturbed),
    "rail-into": Form(unfolded_bounces),
    "restitution-bounce": Form(_bounce_right),
    "head-on": Form(_one_collision),
    "half-ball-cut": Form(_one_collision),
    "thin-cut": Form(_one_collision),
    "unequal-balls": Form(_one_collision),
    "unbounded-cut": Form(_one_collision),
    "catch-up": Form(_one_collision),
    "moving-moving": Form(_one_collision),
    "figure4-head-on": Form(_one_collision),
    "figure4-skewed": Form(_one_collision),
    "restitution-head-on": Form(_one_collision),
    "restitution-cut": Form(_one_collision),
    "three-ball-chain": Form(_chain),
    "cradle": Form(_chain),
    "three-ball-symmetric": Form(collision_with_two),
    "frozen-to-cushion": Form(_squeezed_out),
    "sliding-stun": Form(_undisturbed, motion="sliding"),
    "sliding-swerve": Form(_undisturbed, motion="sliding"),
    "stun-shot": Form(_one_collision, motion="sliding"),
    "draw-shot": Form(_one_collision, motion="sliding"),
    "cue-draw": Form(_one_collision, motion="sliding"),
    "cue-masse": Form(_collision_of_the_last, motion="sliding"),
    "follow-shot": Form(_one_collision, motion="sliding"),
    "half-ball-rolling": Form(_one_collision, motion="sliding"),
    "masse": Form(_collision_of_the_last, motion="sliding"),
    "throw-slip": Form(_one_collision, motion="sliding"),
    "throw-stick": Form(_one_collision, motion="sliding"),
    "throw-alciatore": Form(_one_collision, motion="sliding"),
    "gearing": Form(_one_collision, motion="sliding"),
    "english-running": Form(_bounce_right, motion="sliding"),
    "english-check": Form(_bounce_right, motion="sliding"),
    "han-running": Form(_bounce_right, motion="sliding"),
    "han-check": Form(_bounce_right, motion="sliding"),
    "thirty-degree-rule": Form(_separate_pairs, motion="sliding"),
    "throw-by-angle": Form(_separate_pairs, motion="sliding"),
    "throw-by-spin": Form(_separate_pairs, motion="sliding"),
    "push": Form(pushed_along, motion="sliding"),
    "wedged": Form(wedged, motion="sliding"),
    "air-rolls": Form(alone_in_air, motion="sliding", air=True),
    "air-paper": Form(alone_in_air, air=True),
    "air-drag": Form(alone_in_air, air=True),
    "cloth-quadratic": Form(alone_in_air, air=True),
    "air-drag-sliding": Form(alone_in_air, motion="sliding", air=True),
    "cloth-quadratic-sliding": Form(alone_in_air, motion="sliding", air=True),
    "air-slides": Form(alone_in_air, motion="sliding", air=True),
    "air-drop": Form(fall_in_air, motion="sliding", air=True, flight=True),
    "flight-throw": Form(alone_in_flight, motion="sliding", flight=True),
    "flight-lands": Form(alone_in_flight, motion="sliding", flight=True),
    "flight-bounces": Form(alone_in_flight, motion="sliding", flight=True),
    **{f"galperin-{k}": Form(unfolded_masses) for k in range(5)},
}
"""Solvers by name of scene; `closed_form` applies them."""
