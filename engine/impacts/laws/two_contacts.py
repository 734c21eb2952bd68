"""Equations of an impact with friction at the contact of the collision and at the cloth.

The laws that integrate over the impact share these equations; each law fills in a `Model`. The
independent variable is the normal impulse p of the collision, divided by a mass. Each contact rubs
against its slip, whose direction changes during the impact. Both slips, two numbers each, obey

    d(slips)/dp = push + (effect of friction at the contact) + (effect of friction at the cloth)

with constant coefficients, so the slips alone are the state. All speeds, and p, are in units of the
approach speed before the impact. `impulse_integrator` integrates the equations.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ghostball.engine.core.kernel import kernel

TURNS = 3.5
"""Effect of friction on its own slip, if only the ball's velocity and spin change."""


class Slips(NamedTuple):
    """Numbers for both contacts: slips, changes of slips, or impulses of friction."""

    across: float  # of the colliding contact
    along: float
    n: float  # of the ball on the cloth
    t: float
    p: float  # in a change: the impulse that has caused the change
    work: float  # in a change: the integral of `approach_change_of` over p


class Model(NamedTuple):
    """Constants of one impact; "across" and "along" are tangential, and "along" is horizontal.

    Each law chooses the units of the impulses of friction; these constants are effects per unit.
    The components along the cloth (`along` and `t`) affect only each other, and so do `across` and
    `n`.
    """

    friction: float  # coefficient of the contact
    cloth_friction: float  # coefficient of the cloth
    load: float  # load on the cloth per unit of the normal force
    load_across: float  # load on the cloth per unit of friction across
    restitution: float
    speed: float  # effect of one unit of p on the approach speed; negative
    speed_across: float  # effect of friction across on the approach speed
    speed_cloth: float  # effect of the cloth's friction along n on the approach speed
    push_across: float  # effect of one unit of p on the slip across
    push_n: float  # effect of one unit of p on the cloth's slip along n
    across: float  # effect of friction across on the slip across
    across_cloth: float  # effect of the cloth's friction along n on the slip across
    along_cloth: float  # effect of the cloth's friction along t on the slip along
    n_across: float  # effect of friction across on the cloth's slip along n
    t_along: float  # effect of friction along on the cloth's slip along t
    start: Slips  # just before the impact


class Held(NamedTuple):
    """Whether friction holds each slip.

    The friction of a held slip is proportional to the slip divided by `still`.
    """

    still: float
    contact: bool
    cloth: bool


class Outcome(NamedTuple):
    """The impulses of an impact, in units of the speed of approach."""

    speed: float  # approach speed after the impact
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
        a.p + factor * b.p,
        a.work + factor * b.work,
    )


@kernel
def length(x: float, y: float) -> float:
    """Return sqrt(x^2 + y^2)."""
    return math.sqrt(x * x + y * y)


@kernel
def held_of(change: Slips, still: float, model: Model) -> Held:
    """Return which slips are held; this doesn't change within a step, so that steps are smooth."""
    slips = plus(model.start, 1.0, change)
    contact = length(slips.across, slips.along) <= still
    return Held(still, contact, length(slips.n, slips.t) <= still)


@kernel
def per_slip(x: float, y: float, held: bool, still: float) -> float:
    """Return the factor on a slip (x, y) that gives the direction of its friction."""
    return 1.0 / (still if held else max(length(x, y), 1e-300))


@kernel
def _friction(change: Slips, held: Held, model: Model) -> Slips:
    """Return the friction of both contacts per unit of the normal force.

    The cloth can't pull: if the impact lifts the ball, the load is 0.
    """
    slips = plus(model.start, 1.0, change)
    share = -model.friction * per_slip(slips.across, slips.along, held.contact, held.still)
    across, along = share * slips.across, share * slips.along
    load = max(model.load + model.load_across * across, 0.0)
    share = -model.cloth_friction * load * per_slip(slips.n, slips.t, held.cloth, held.still)
    return Slips(across, along, share * slips.n, share * slips.t, 0.0, 0.0)


@kernel
def _changed(friction: Slips, model: Model) -> Slips:
    """Return the effect of impulses of friction on the slips."""
    return Slips(
        model.across * friction.across + model.across_cloth * friction.n,
        TURNS * friction.along + model.along_cloth * friction.t,
        model.n_across * friction.across + TURNS * friction.n,
        model.t_along * friction.along + TURNS * friction.t,
        0.0,
        0.0,
    )


@kernel
def rates_of(change: Slips, held: Held, model: Model) -> Slips:
    """Return the effect of one unit of p on the slips, on p, and on the work."""
    rates = _changed(_friction(change, held, model), model)
    return Slips(
        rates.across + model.push_across,
        rates.along,
        rates.n + model.push_n,
        rates.t,
        1.0,
        approach_change_of(change, model),
    )


@kernel
def approach_change_of(change: Slips, model: Model) -> float:
    """Return the effect on the approach speed of the friction that changed the slips.

    `drift_of` is the effect of p itself.
    """
    friction = _impulses(change, model)
    return model.speed_across * friction.across + model.speed_cloth * friction.n


@kernel
def drift_of(model: Model) -> float:
    """Return the effect of one unit of p on the approach speed if no slip changes."""
    pushed = Slips(model.push_across, 0.0, model.push_n, 0.0, 0.0, 0.0)
    return model.speed - approach_change_of(pushed, model)


@kernel
def speed_rate_of(change: Slips, held: Held, model: Model) -> float:
    """Return the effect of one unit of p on the approach speed."""
    friction = _friction(change, held, model)
    return model.speed + model.speed_across * friction.across + model.speed_cloth * friction.n


@kernel
def _impulses(change: Slips, model: Model) -> Slips:
    """Return the impulses of friction that cause a change of the slips."""
    over = 1.0 / (model.across * TURNS - model.across_cloth * model.n_across)
    other = 1.0 / (TURNS * TURNS - model.along_cloth * model.t_along)
    return Slips(
        over * (TURNS * change.across - model.across_cloth * change.n),
        other * (TURNS * change.along - model.along_cloth * change.t),
        over * (model.across * change.n - model.n_across * change.across),
        other * (TURNS * change.t - model.t_along * change.along),
        0.0,
        0.0,
    )


@kernel
def outcome_of(change: Slips, speed: float, model: Model) -> Outcome:
    """Return the outcome of an impact; the direct effect of p on the slips isn't friction."""
    pushed = Slips(model.push_across, 0.0, model.push_n, 0.0, 0.0, 0.0)
    return Outcome(speed, change.p, _impulses(plus(change, -change.p, pushed), model))
