"""Equations of an impact during which two contacts rub: the one that collides, and the cloth's.

What the laws that integrate over the impact share: each fills in a `Model`. The independent
variable is the normal impulse p of the contact that collides, divided by a mass. Each contact rubs
against its slip, whose direction changes meanwhile; both slips, two numbers each, obey

    d(slips)/dp = push + (what friction at the contact does) + (what friction of the cloth does)

with constant coefficients, so that the slips alone are the state. All speeds, p too, are in units
of the speed of approach before the impact. `impulse_integrator` follows them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ghostball.engine.core.kernel import kernel

TURNS = 3.5
"""What friction does to its own slip, where only the ball's centre and spin give way."""


class Slips(NamedTuple):
    """Both slips, or what changes of them; or impulses of friction at the same places."""

    across: float  # of the contact
    along: float
    n: float  # of the ball on the cloth
    t: float
    work: float  # of a change: the integral over p of `speed_of` it


class Model(NamedTuple):
    """Constants of one impact; "across" is across the cloth's plane, "along" is in it.

    Impulses of friction are counted as the law chooses; what each does per unit is said here. Along
    t, slip and impulse of a contact go with those of the other alone, and so do the two others.
    """

    friction: float  # coefficient of the contact
    cloth_friction: float  # and of the cloth
    load: float  # of the cloth, per unit of the normal force
    load_across: float  # and per unit of friction across
    restitution: float
    speed: float  # what one unit of p does to the speed of approach; negative
    speed_across: float  # what friction across does to it
    speed_cloth: float  # and that of the cloth along n
    push_across: float  # what one unit of p does to the slip across
    push_n: float  # and to the cloth's slip along n
    across: float  # what friction across does to the slip across
    across_cloth: float  # what the cloth's friction along n does to it
    along_cloth: float  # what the cloth's friction along t does to the slip along
    n_across: float  # what friction across does to the cloth's slip along n
    t_along: float  # what friction along does to that along t
    start: Slips  # just before the impact


class Held(NamedTuple):
    """What divides each slip in the friction against it; a slip below `still` is held."""

    still: float
    contact: bool
    cloth: bool


class Outcome(NamedTuple):
    """The impulses of an impact, in units of the speed of approach."""

    speed: float  # of approach, afterwards
    normal: float
    friction: Slips  # integrals of both frictions


@kernel
def plus(a: Slips, factor: float, b: Slips) -> Slips:
    """Return a + factor * b."""
    return Slips(
        a.across + factor * b.across,
        a.along + factor * b.along,
        a.n + factor * b.n,
        a.t + factor * b.t,
        a.work + factor * b.work,
    )


@kernel
def length(x: float, y: float) -> float:
    """Return sqrt(x^2 + y^2)."""
    return math.sqrt(x * x + y * y)


@kernel
def held_of(change: Slips, still: float, model: Model) -> Held:
    """Return which slips are held: over a whole step, so that it is smooth."""
    slips = plus(model.start, 1.0, change)
    contact = length(slips.across, slips.along) <= still
    return Held(still, contact, length(slips.n, slips.t) <= still)


@kernel
def per_slip(x: float, y: float, held: bool, still: float) -> float:
    """Return by what a slip (x, y) is divided in the friction against it."""
    return 1.0 / (still if held else max(length(x, y), 1e-300))


@kernel
def _friction(change: Slips, held: Held, model: Model) -> Slips:
    """Return the friction of both contacts per unit of the normal force.

    The cloth can't pull: where the impact lifts the ball its load is 0.
    """
    slips = plus(model.start, 1.0, change)
    share = -model.friction * per_slip(slips.across, slips.along, held.contact, held.still)
    across, along = share * slips.across, share * slips.along
    load = max(model.load + model.load_across * across, 0.0)
    share = -model.cloth_friction * load * per_slip(slips.n, slips.t, held.cloth, held.still)
    return Slips(across, along, share * slips.n, share * slips.t, 0.0)


@kernel
def _changed(friction: Slips, model: Model) -> Slips:
    """Return what impulses of friction do to the slips."""
    return Slips(
        model.across * friction.across + model.across_cloth * friction.n,
        TURNS * friction.along + model.along_cloth * friction.t,
        model.n_across * friction.across + TURNS * friction.n,
        model.t_along * friction.along + TURNS * friction.t,
        0.0,
    )


@kernel
def rates_of(change: Slips, held: Held, model: Model) -> Slips:
    """Return what one unit of p does to the slips, and to the work."""
    rates = _changed(_friction(change, held, model), model)
    return Slips(
        rates.across + model.push_across,
        rates.along,
        rates.n + model.push_n,
        rates.t,
        speed_of(change, model),
    )


@kernel
def speed_of(change: Slips, model: Model) -> float:
    """Return how much faster the approach is where the slips have changed by this much.

    Counted from where p alone would have brought it: see `drift_of`.
    """
    friction = _impulses(change, model)
    return model.speed_across * friction.across + model.speed_cloth * friction.n


@kernel
def drift_of(model: Model) -> float:
    """Return what one unit of p does to the speed of approach where no slip changes."""
    return model.speed - speed_of(Slips(model.push_across, 0.0, model.push_n, 0.0, 0.0), model)


@kernel
def speed_rate_of(change: Slips, held: Held, model: Model) -> float:
    """Return what one unit of p does to the speed of approach."""
    friction = _friction(change, held, model)
    return model.speed + model.speed_across * friction.across + model.speed_cloth * friction.n


@kernel
def _impulses(change: Slips, model: Model) -> Slips:
    """Return the impulses of friction that change the slips by this much."""
    over = 1.0 / (model.across * TURNS - model.across_cloth * model.n_across)
    other = 1.0 / (TURNS * TURNS - model.along_cloth * model.t_along)
    return Slips(
        over * (TURNS * change.across - model.across_cloth * change.n),
        other * (TURNS * change.along - model.along_cloth * change.t),
        over * (model.across * change.n - model.n_across * change.across),
        other * (TURNS * change.t - model.t_along * change.along),
        0.0,
    )


@kernel
def outcome_of(change: Slips, p: float, speed: float, model: Model) -> Outcome:
    """Return the outcome; what p does to the slips took no friction."""
    pushed = Slips(model.push_across, 0.0, model.push_n, 0.0, 0.0)
    return Outcome(speed, p, _impulses(plus(change, -p, pushed), model))
