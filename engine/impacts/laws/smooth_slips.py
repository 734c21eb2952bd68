"""Steps of an impact while both contacts slip.

As long as no slip is near its end, nothing in an impact is stiff. An explicit method of high order
then needs a tenth of the steps of an implicit one. A slip turns faster the shorter it is, so the
independent variable s of a step stretches short slips: dp = |slip at the contact| ds. With s, the
motion stays smooth also where a slip nearly ends and turns round.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ghostball.engine.core.kernel import kernel
from ghostball.engine.impacts.laws.two_contacts import (
    TURNS,
    Held,
    Model,
    Slips,
    length,
    plus,
    rates_of,
)

_SHORT = 2.0**-13
"""Slip at the contact below which friction makes the equations stiff. A slip on the cloth that is
shorter must grow."""

_DRIVEN = 2.0
"""Least ratio of the drive of a short slip on the cloth to its friction."""

_TINY = 2.0**-60
"""Slip on the cloth after it has begun; only its direction matters."""


class Step(NamedTuple):
    """The change of the slips at the end of a step.

    `growth`: factor on the step's p for the next step, or for another try of this one.
    `is_right`: whether the estimated error is small enough.
    """

    end: Slips
    growth: float
    is_right: bool


@kernel
def is_smooth(slips: Slips, model: Model) -> bool:
    """Return whether `smooth_step` suits these slips: no slip is short, unless it grows."""
    if length(slips.across, slips.along) < _SHORT:
        return False
    if length(slips.n, slips.t) >= _SHORT:
        return True
    n, t, is_driven = _drive(slips, model)
    return is_driven and n * slips.n + t * slips.t > 0.0


@kernel
def begun(slips: Slips, rounding: float, model: Model) -> Slips:
    """Return the slips at the start; a slip on the cloth below `rounding` begins if it is driven.

    It begins in the direction of its drive, because friction of the cloth acts against the slip.
    """
    if length(slips.n, slips.t) > rounding or length(slips.across, slips.along) < _SHORT:
        return slips
    n, t, is_driven = _drive(slips, model)
    if not is_driven:
        return slips
    part = _TINY / length(n, t)
    return Slips(slips.across, slips.along, part * n, part * t, slips.p, slips.work)


@kernel
def _drive(slips: Slips, model: Model) -> tuple[float, float, bool]:
    """Return the rate of the slip on the cloth along n and t, without the friction of the cloth.

    The last value is True if this rate is much larger than the effect of that friction.
    """
    share = -model.friction / length(slips.across, slips.along)
    across, along = share * slips.across, share * slips.along
    load = max(model.load + model.load_across * across, 0.0)
    n, t = model.push_n + model.n_across * across, model.t_along * along
    return n, t, length(n, t) > _DRIVEN * TURNS * (model.cloth_friction * load)


@kernel
def smooth_step(change: Slips, p: float, allowed: float, model: Model) -> Step:
    """Return the slips after an impulse of about p, with an estimated error up to `allowed`.

    The method of order 8 by Dormand and Prince, with estimates of orders 5 and 3 (Hairer, Norsett
    and Wanner 1993, Solving ordinary differential equations I, section II.10, DOP853).

    Contract: the slip at the contact isn't 0.
    """
    k1 = _rates(change, model)
    slips, slip = plus(model.start, 1.0, change), k1.p
    slip_rate = (slips.across * k1.across + slips.along * k1.along) / (slip * slip)
    h = p / max(slip + 0.5 * p * slip_rate, 0.25 * slip)
    at = plus(change, 0.05260015195876773 * h, k1)
    k2 = _rates(at, model)
    at = plus(plus(change, 0.0197250569845379 * h, k1), 0.0591751709536137 * h, k2)
    k3 = _rates(at, model)
    at = plus(plus(change, 0.02958758547680685 * h, k1), 0.08876275643042054 * h, k3)
    k4 = _rates(at, model)
    at = plus(plus(change, 0.2413651341592667 * h, k1), -0.8845494793282861 * h, k3)
    at = plus(at, 0.924834003261792 * h, k4)
    k5 = _rates(at, model)
    at = plus(plus(change, 0.037037037037037035 * h, k1), 0.17082860872947386 * h, k4)
    at = plus(at, 0.12546768756682242 * h, k5)
    k6 = _rates(at, model)
    at = plus(plus(change, 0.037109375 * h, k1), 0.17025221101954405 * h, k4)
    at = plus(plus(at, 0.06021653898045596 * h, k5), -0.017578125 * h, k6)
    k7 = _rates(at, model)
    at = plus(plus(change, 0.03709200011850479 * h, k1), 0.17038392571223998 * h, k4)
    at = plus(plus(at, 0.10726203044637328 * h, k5), -0.015319437748624402 * h, k6)
    at = plus(at, 0.008273789163814023 * h, k7)
    k8 = _rates(at, model)
    at = plus(plus(change, 0.6241109587160757 * h, k1), -3.3608926294469414 * h, k4)
    at = plus(plus(at, -0.868219346841726 * h, k5), 27.59209969944671 * h, k6)
    at = plus(plus(at, 20.154067550477894 * h, k7), -43.48988418106996 * h, k8)
    k9 = _rates(at, model)
    at = plus(plus(change, 0.47766253643826434 * h, k1), -2.4881146199716677 * h, k4)
    at = plus(plus(at, -0.590290826836843 * h, k5), 21.230051448181193 * h, k6)
    at = plus(plus(at, 15.279233632882423 * h, k7), -33.28821096898486 * h, k8)
    at = plus(at, -0.020331201708508627 * h, k9)
    k10 = _rates(at, model)
    at = plus(plus(change, -0.9371424300859873 * h, k1), 5.186372428844064 * h, k4)
    at = plus(plus(at, 1.0914373489967295 * h, k5), -8.149787010746927 * h, k6)
    at = plus(plus(at, -18.52006565999696 * h, k7), 22.739487099350505 * h, k8)
    at = plus(plus(at, 2.4936055526796523 * h, k9), -3.0467644718982196 * h, k10)
    k11 = _rates(at, model)
    at = plus(plus(change, 2.273310147516538 * h, k1), -10.53449546673725 * h, k4)
    at = plus(plus(at, -2.0008720582248625 * h, k5), -17.9589318631188 * h, k6)
    at = plus(plus(at, 27.94888452941996 * h, k7), -2.8589982771350235 * h, k8)
    at = plus(plus(at, -8.87285693353063 * h, k9), 12.360567175794303 * h, k10)
    at = plus(at, 0.6433927460157636 * h, k11)
    k12 = _rates(at, model)
    end = plus(plus(change, 0.054293734116568765 * h, k1), 4.450312892752409 * h, k6)
    end = plus(plus(end, 1.8915178993145003 * h, k7), -5.801203960010585 * h, k8)
    end = plus(plus(end, 0.3111643669578199 * h, k9), -0.1521609496625161 * h, k10)
    end = plus(plus(end, 0.20136540080403034 * h, k11), 0.04471061572777259 * h, k12)
    none = Slips(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    fifth = plus(plus(none, 0.01312004499419488 * h, k1), -1.2251564463762044 * h, k6)
    fifth = plus(plus(fifth, -0.4957589496572502 * h, k7), 1.6643771824549864 * h, k8)
    fifth = plus(plus(fifth, -0.35032884874997366 * h, k9), 0.3341791187130175 * h, k10)
    fifth = plus(plus(fifth, 0.08192320648511571 * h, k11), -0.022355307863886294 * h, k12)
    third = plus(
        plus(plus(end, -1.0, change), -0.2440944881889764 * h, k1), -0.7338466882816118 * h, k9
    )
    third = plus(third, -0.022058823529411766 * h, k12)
    x, y = _size(fifth), _size(third)
    error = x * (x / max(math.sqrt(x * x + 0.01 * (y * y)), 1e-300))
    ratio = allowed / max(error, 1e-8 * allowed)
    growth = 0.9 * math.sqrt(math.sqrt(math.sqrt(ratio)))
    is_right = error <= allowed
    if is_right:
        slips = plus(model.start, 1.0, end)
        growth *= length(slips.across, slips.along) / slip
    return Step(end, growth, is_right)


@kernel
def _rates(change: Slips, model: Model) -> Slips:
    """Return the rates in s: the rates in p, multiplied by the slip at the contact."""
    slips = plus(model.start, 1.0, change)
    slip = length(slips.across, slips.along)
    none = Slips(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return plus(none, slip, rates_of(change, Held(0.0, False, False), model))


@kernel
def _size(error: Slips) -> float:
    """Return the largest error: of a slip, of p, or of the work."""
    slip = max(length(error.across, error.along), length(error.n, error.t))
    return max(slip, abs(error.p), abs(error.work))
