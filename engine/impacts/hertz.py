"""The force of a contact that lasts: Hertz's law, with a loss that gives the restitution.

Two elastic balls whose surfaces overlap by d push each other by K d^1.5, with
K = 4/3 E* sqrt(R), 1/R = 1/R_a + 1/R_b and E* = E / (2 (1 - nu^2)) for two balls of one material
(Hertz 1882; Johnson, Contact Mechanics, 1985, section 4.2). In an impact at the speed v of balls
with the reduced mass m the largest overlap is (5 m v^2 / 4 K)^0.4, and the contact lasts 2.943
times that overlap over v.

The loss: the force is K d^1.5 (1 + beta u), where u is the rate of the overlap over the speed w at
which the balls would part without any loss, w^2 = (rate of d)^2 + 4 K d^2.5 / 5 m. Hunt and
Crossley (1975) divide the rate by a constant speed, so their restitution falls with the speed of
the impact. Here the divisor is the speed of this impact, so the restitution e doesn't depend on
the speed. With p = 4 K d^2.5 / 5 m, d(w^2)/dp = -beta u, and the integral over a whole impact is

    -ln e = beta int_{-1}^{1} u^2 / (1 + beta (u - u^3)) du = 2/3 beta + 16/315 beta^3 + ...

The force is continuous, as smooth as Hertz's where a contact begins, and never pulls for beta <= 1,
that is, for e >= 0.485. Tsuji, Tanaka and Ishida (1992) also get a restitution that doesn't depend
on the speed, by a force proportional to d^0.25: that force isn't smooth where a contact begins,
which ruins the order of an integration, and pulls where it ends.
"""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel

CONTACT_TIME = 2.9432751843247043
"""Duration of an impact without loss, in units of the largest overlap over the speed:
2 int_0^1 dx / sqrt(1 - x^2.5)."""

_ROOT_STEPS = 64
"""Largest number of Newton steps for a fifth root. The first step may overshoot. Each further step
reduces an estimate that is too large by up to a fifth, and the last steps double the digits."""


@kernel
def stiffness(modulus: float, radius: float, other: float) -> float:
    """Return K [N/m^1.5] of the contact of two balls with these radii [m]; `modulus` E* [Pa]."""
    return 4.0 / 3.0 * modulus * math.sqrt(radius * (other / (radius + other)))


@kernel
def fifth_root(a: float) -> float:
    """Return a^(1/5) for a > 0, to a few ulps, with + - * / and square roots only."""
    if a == 0.0:
        return 0.0
    eighth = math.sqrt(math.sqrt(math.sqrt(a)))
    root = eighth * math.sqrt(eighth)  # a^(3/16), near a^(1/5)
    for turn in range(_ROOT_STEPS):
        square, before = root * root, root
        root = 0.8 * root + 0.2 * (a / (square * square))
        if turn > 0 and root >= before:
            break
    return root


@kernel
def deepest_overlap(speed: float, stiff: float, mass: float) -> float:
    """Return the largest overlap [m] at an impact speed [m/s] and a reduced mass [kg]."""
    q = 1.25 * mass * speed * speed / stiff
    return fifth_root(q * q)


@kernel
def contact_time(speed: float, stiff: float, mass: float) -> float:
    """Return the duration [s] of an impact at `speed` [m/s] without loss."""
    return CONTACT_TIME * deepest_overlap(speed, stiff, mass) / speed


@kernel(inline=True)
def push(overlap: float, rate: float, stiff: float, energy: float, loss: float) -> float:
    """Return the force [N] with which two balls push each other apart.

    `overlap` [m], not negative, changes at `rate` [m/s]; `energy` is 4/5 `stiff` over the reduced
    mass; `loss` is beta.
    """
    root = math.sqrt(overlap)
    speed = math.sqrt(rate * rate + energy * (overlap * overlap * root))
    if speed == 0.0:
        return 0.0
    return stiff * overlap * root * (1.0 + loss * (rate / speed))


def loss_of(restitution: float) -> float:
    """Return beta of `push` for a restitution from `LEAST_RESTITUTION` to 1; 0 for 1.

    The module's equation for e is solved by Newton's method. ln e = -2 artanh((1 - e) / (1 + e)) is
    computed by its series, because the last bit of a library's logarithm depends on the machine.
    """
    z = (1.0 - restitution) / (1.0 + restitution)
    logarithm, power = 0.0, 2.0 * z
    for k in range(40):
        logarithm += power / (2 * k + 1)
        power *= z * z
    loss = 1.5 * logarithm
    for _ in range(8):
        value, slope, power = 0.0, 0.0, 1.0
        for k in range(40):
            integral = _integral(k)
            slope += (2 * k + 1) * integral * power
            value += integral * power * loss
            power *= loss * loss
        loss -= (value - logarithm) / slope
    return loss


def _integral(k: int) -> float:
    """Return the integral of u^2 (u - u^3)^2k from -1 to 1.

    It is (2k)! / (a (a + 1) ... (a + 2k)) with a = k + 3/2.
    """
    product = 1.0 / (k + 1.5)
    for n in range(1, 2 * k + 1):
        product *= n / (k + 1.5 + n)
    return product
