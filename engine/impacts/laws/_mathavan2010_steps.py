"""The equations of motion of `cushion_mathavan2010`, and two ways to take a step in the impulse.

The independent variable is the normal impulse at the nose over the ball's mass, p [m/s]. The
shorter a slip is, the faster friction turns it: the direction of a slip of length 0 is a
singularity, and near it the equations are stiff. So there is an explicit method, and an implicit
one for stiffness.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from engine.core.kernel import kernel

# Which contact sticks. Both can't: then the ball would be stuck between them, with vn = 0.
NEITHER = 0
NOSE = 1
CLOTH = 2


class Model(NamedTuple):
    """Constants of one impact; theta is the angle at which the centre sees the nose above n."""

    sine: float  # of theta
    cosine: float
    nose_friction: float  # coefficient
    cloth_friction: float
    along: float  # slip at the nose along t when the ball arrives [m/s]
    skid: float  # slip on the cloth along t then [m/s]
    planar: bool  # whether both are 0, so that everything happens in the plane of n and z


class Motion(NamedTuple):
    """State of the ball during the impact, or a change of it, or its rate."""

    vn: float  # [m/s]
    down: float  # slip at the nose across t: towards the cushion and down [m/s]
    nose_t: float  # impulse of the nose along t so far, over the mass [m/s]
    cloth_t: float  # and that of the cloth
    work: float  # stored in the cushion, over the mass [m^2/s^2]


class Slips(NamedTuple):
    """Lengths [m/s] and directions of the ball's slips, at the nose and on the cloth."""

    nose: float
    down: float
    along: float
    cloth: float
    n: float
    t: float


class Friction(NamedTuple):
    """Friction on the ball per unit of the nose's normal force: of the nose, and of the cloth."""

    down: float
    along: float
    n: float
    t: float


@kernel
def plus(motion: Motion, factor: float, change: Motion) -> Motion:
    """Return motion + factor * change."""
    return Motion(
        motion.vn + factor * change.vn,
        motion.down + factor * change.down,
        motion.nose_t + factor * change.nose_t,
        motion.cloth_t + factor * change.cloth_t,
        motion.work + factor * change.work,
    )


@kernel
def slips_of(motion: Motion, model: Model) -> Slips:
    """Return the slips; the direction of none is (0, 0).

    The slip of the ball on the cloth along n is vn - R wt; what it has across t at the nose is
    vn sine + R wt; so their sum is (1 + sine) vn.
    """
    cross = 1.0 - 2.5 * model.sine
    down = motion.down
    along = model.along + 3.5 * motion.nose_t + cross * motion.cloth_t
    n = (1.0 + model.sine) * motion.vn - motion.down
    t = model.skid + cross * motion.nose_t + 3.5 * motion.cloth_t
    nose, cloth = math.sqrt(down * down + along * along), math.sqrt(n * n + t * t)
    per_nose = 1.0 / nose if nose > 0.0 else 0.0
    per_cloth = 1.0 / cloth if cloth > 0.0 else 0.0
    return Slips(nose, per_nose * down, per_nose * along, cloth, per_cloth * n, per_cloth * t)


@kernel
def load_of(down: float, model: Model) -> float:
    """Return the cloth's normal force per unit of the nose's, from the nose's friction across t.

    The cloth can't pull: where the nose lifts the ball it is 0, and there is no friction either.
    What holds the ball down then does no work, since the ball has no vertical velocity.
    """
    return max(model.sine + model.cosine * down, 0.0)


@kernel
def hold_at_nose(n: float, model: Model) -> tuple[float, float]:
    """Return the friction across t that keeps the slip at the nose 0, and the cloth's load.

    n is the direction of the slip on the cloth. The two depend on one another: the friction of the
    nose loads the cloth, whose friction turns the ball. No finite friction is in balance where that
    feeds back by more than 1 (the cloth's friction near 1); then the nose can't hold.
    """
    if model.sine <= 0.0:  # the nose lifts the ball off the cloth
        return model.sine * model.cosine / (2.5 + model.sine * model.sine), 0.0
    drag = (2.5 - model.sine) * model.cloth_friction * n
    stiffness = 2.5 + model.sine * model.sine + drag * model.cosine
    if stiffness <= 0.0:
        return math.inf, 0.0
    return model.sine * (model.cosine - drag) / stiffness, 3.5 * model.sine / stiffness


@kernel
def friction_of(slips: Slips, held: int, model: Model) -> Friction:
    """Return the friction at both contacts; at the one that is held, what keeps its slip 0."""
    cross = 1.0 - 2.5 * model.sine
    if held == NOSE:
        down, load = hold_at_nose(slips.n, model)
        grip = model.cloth_friction * load
        return Friction(down, cross / 3.5 * (grip * slips.t), -grip * slips.n, -grip * slips.t)
    down, along = -model.nose_friction * slips.down, -model.nose_friction * slips.along
    if held == CLOTH:
        n = (model.cosine + (2.5 - model.sine) * down) / 3.5
        return Friction(down, along, n, -cross / 3.5 * along)
    grip = model.cloth_friction * load_of(down, model)
    return Friction(down, along, -grip * slips.n, -grip * slips.t)


@kernel
def rates_of(motion: Motion, held: int, model: Model) -> Motion:
    """Return d(motion)/dp."""
    friction = friction_of(slips_of(motion, model), held, model)
    vn, down = _response(friction, model)
    return Motion(
        vn - model.cosine,
        down - model.sine * model.cosine,
        friction.along,
        friction.t,
        model.cosine * motion.vn,
    )


@kernel
def _response(friction: Friction, model: Model) -> tuple[float, float]:
    """Return the rates of vn and of the slip across t at the nose that friction causes."""
    sine = model.sine
    return (
        sine * friction.down + friction.n,
        (2.5 + sine * sine) * friction.down - (2.5 - sine) * friction.n,
    )


# Of 2, 4 ... 10 substeps: products of j^2 / (j^2 - i^2) over all i of 1 ... 5 that are not j; and
# from them those without i = 1.
_WEIGHTS = (1 / 8640, -64 / 945, 6561 / 4480, -16384 / 2835, 390625 / 72576)
_ERROR_WEIGHTS = (
    1 / 8640,
    -64 / 945 + 16 / 315,
    6561 / 4480 - 729 / 560,
    -16384 / 2835 + 1024 / 189,
    390625 / 72576 - 15625 / 3024,
)


@kernel
def smooth_step(motion: Motion, h: float, held: int, model: Model) -> tuple[Motion, Motion]:
    """Return the motion after an impulse h, and an estimate of its error.

    Order 10, and 8 for the estimate: the modified midpoint rule with 2, 4, 6, 8 and 10 substeps,
    extrapolated (Gragg 1965; Bulirsch and Stoer 1966). The weights are products of
    j^2 / (j^2 - i^2). Explicit: for h below about the length of a slip over its friction.
    """
    first = rates_of(motion, held, model)
    fine = error = Motion(0.0, 0.0, 0.0, 0.0, 0.0)
    for i in range(5):
        change = _midpoint(motion, h, 2 * (i + 1), first, held, model)
        fine = plus(fine, _WEIGHTS[i], change)
        error = plus(error, _ERROR_WEIGHTS[i], change)
    return plus(motion, 1.0, fine), error


@kernel
def _midpoint(
    motion: Motion, h: float, count: int, first: Motion, held: int, model: Model
) -> Motion:
    """Return the change of the motion by `count` substeps of the modified midpoint rule."""
    h = h / count
    old, now = Motion(0.0, 0.0, 0.0, 0.0, 0.0), plus(Motion(0.0, 0.0, 0.0, 0.0, 0.0), h, first)
    for _ in range(count - 1):
        old, now = now, plus(old, 2.0 * h, rates_of(plus(motion, 1.0, now), held, model))
    return now


_GAMMA = 0.21193756319429014


@kernel
def stiff_step(motion: Motion, h: float, held: int, model: Model) -> tuple[Motion, Motion]:
    """Return the motion after an impulse h, and an estimate of its error.

    Rosenbrock method of order 5, and 4 for the estimate, stiffly accurate: Rodas5P (Steinebach
    2023, BIT Numerical Mathematics 63, 27), in the form that needs no product with the Jacobian.
    """
    jacobian = _jacobian(motion, h, held, model)
    none = Motion(0.0, 0.0, 0.0, 0.0, 0.0)
    a = _stage(motion, none, h, held, model, jacobian)
    at = plus(motion, 3.0, a)
    of = plus(none, -14.155112264123755, a)
    b = _stage(at, of, h, held, model, jacobian)
    at = plus(plus(motion, 2.849394379747939, a), 0.45842242204463923, b)
    of = plus(plus(none, -17.97296035885952, a), -2.859693295451294, b)
    c = _stage(at, of, h, held, model, jacobian)
    at = plus(plus(motion, -6.954028509809101, a), 2.489845061869568, b)
    at = plus(at, -10.358996098473584, c)
    of = plus(plus(none, 147.12150275711716, a), -1.41221402718213, b)
    of = plus(of, 71.68940251302358, c)
    d = _stage(at, of, h, held, model, jacobian)
    at = plus(plus(motion, 2.8029986275628964, a), 0.5072464736228206, b)
    at = plus(plus(at, -0.3988312541770524, c), -0.04721187230404641, d)
    of = plus(plus(none, 165.43517024871676, a), -0.4592823456491126, b)
    of = plus(plus(of, 42.90938336958603, c), -5.961986721573306, d)
    e = _stage(at, of, h, held, model, jacobian)
    at = plus(plus(motion, -7.502846399306121, a), 2.561846144803919, b)
    at = plus(plus(at, -11.627539656261098, c), -0.18268767659942256, d)
    at = plus(at, 0.030198172008377946, e)
    of = plus(plus(none, 24.854864614690072, a), -3.0009227002832186, b)
    of = plus(plus(of, 47.4931110020768, c), 5.5814197821558125, d)
    of = plus(of, -0.6610691825249471, e)
    f = _stage(at, of, h, held, model, jacobian)
    at = plus(at, 1.0, f)
    of = plus(plus(none, 30.91273214028599, a), -3.1208243349937974, b)
    of = plus(plus(of, 77.79954646070892, c), 34.28646028294783, d)
    of = plus(plus(of, -19.097331116725623, e), -28.087943162872662, f)
    g = _stage(at, of, h, held, model, jacobian)
    at = plus(at, 1.0, g)
    of = plus(plus(none, 37.80277123390563, a), -3.2571969029072276, b)
    of = plus(plus(of, 112.26918849496327, c), 66.9347231244047, d)
    of = plus(plus(of, -40.06618937091002, e), -54.66780262877968, f)
    of = plus(of, -9.48861652309627, g)
    error = _stage(at, of, h, held, model, jacobian)
    return plus(at, 1.0, error), error


class _Jacobian(NamedTuple):
    """The derivative of the rates, times h gamma, and what inverts 1 minus it.

    The rates depend on the motion through the directions of both slips, two angles, and through vn
    in the work. So but for that it has rank 2: what an angle does, times how the motion turns it.
    """

    by_nose: Motion  # change of the rates by an angle, its work left out
    by_cloth: Motion
    turns_nose: Motion  # derivative of an angle by the motion
    turns_cloth: Motion
    nose_nose: float  # inverse of the 2 by 2 matrix that is left
    nose_cloth: float
    cloth_nose: float
    cloth_cloth: float
    work: float


@kernel
def _jacobian(motion: Motion, h: float, held: int, model: Model) -> _Jacobian:
    """Return the Jacobian at the start of a step; a slip of length 0 counts as held."""
    slips = slips_of(motion, model)
    share = h * _GAMMA
    by_nose = _by_angle(_friction_by_nose(slips, held, model), share, model)
    by_cloth = _by_angle(_friction_by_cloth(slips, held, model), share, model)
    cross = 1.0 - 2.5 * model.sine
    per_nose = 1.0 / slips.nose if slips.nose > 0.0 and held != NOSE else 0.0
    per_cloth = 1.0 / slips.cloth if slips.cloth > 0.0 and held != CLOTH else 0.0
    down, along = per_nose * slips.down, per_nose * slips.along
    n, t = per_cloth * slips.n, per_cloth * slips.t
    turns_nose = Motion(0.0, -along, 3.5 * down, cross * down, 0.0)
    turns_cloth = Motion(-(1.0 + model.sine) * t, t, cross * n, 3.5 * n, 0.0)
    a = 1.0 - _dot(turns_nose, by_nose)
    b = -_dot(turns_nose, by_cloth)
    c = -_dot(turns_cloth, by_nose)
    d = 1.0 - _dot(turns_cloth, by_cloth)
    per = 1.0 / (a * d - b * c)
    work = share * model.cosine
    return _Jacobian(
        by_nose, by_cloth, turns_nose, turns_cloth, per * d, -per * b, -per * c, per * a, work
    )


@kernel
def _stage(
    at: Motion, of: Motion, h: float, held: int, model: Model, jacobian: _Jacobian
) -> Motion:
    """Return gamma (h rates + of), solved with 1 minus the Jacobian."""
    right = plus(of, h, rates_of(at, held, model))
    nose, cloth = _dot(jacobian.turns_nose, right), _dot(jacobian.turns_cloth, right)
    by_nose = jacobian.nose_nose * nose + jacobian.nose_cloth * cloth
    by_cloth = jacobian.cloth_nose * nose + jacobian.cloth_cloth * cloth
    right = plus(plus(right, by_nose, jacobian.by_nose), by_cloth, jacobian.by_cloth)
    return Motion(
        _GAMMA * right.vn,
        _GAMMA * right.down,
        _GAMMA * right.nose_t,
        _GAMMA * right.cloth_t,
        _GAMMA * (right.work + jacobian.work * right.vn),
    )


@kernel
def _dot(a: Motion, b: Motion) -> float:
    """Return the product of two motions, their work left out."""
    return a.vn * b.vn + a.down * b.down + a.nose_t * b.nose_t + a.cloth_t * b.cloth_t


@kernel
def _by_angle(friction: Friction, share: float, model: Model) -> Motion:
    """Return what a change of the friction does to the rates, times `share`."""
    vn, down = _response(friction, model)
    return Motion(share * vn, share * down, share * friction.along, share * friction.t, 0.0)


@kernel
def _friction_by_nose(slips: Slips, held: int, model: Model) -> Friction:
    """Return the derivative of `friction_of` by the angle of the slip at the nose."""
    if held == NOSE:
        return Friction(0.0, 0.0, 0.0, 0.0)
    down, along = model.nose_friction * slips.along, -model.nose_friction * slips.down
    if held == CLOTH:
        cross = 1.0 - 2.5 * model.sine
        return Friction(down, along, (2.5 - model.sine) / 3.5 * down, -cross / 3.5 * along)
    loaded = load_of(-model.nose_friction * slips.down, model) > 0.0
    grip = model.cloth_friction * (model.cosine * down) if loaded else 0.0
    return Friction(down, along, -grip * slips.n, -grip * slips.t)


@kernel
def _friction_by_cloth(slips: Slips, held: int, model: Model) -> Friction:
    """Return the derivative of `friction_of` by the angle of the slip on the cloth."""
    if held == CLOTH:
        return Friction(0.0, 0.0, 0.0, 0.0)
    if held == NOSE:
        _, load = hold_at_nose(slips.n, model)
        if load == 0.0:
            return Friction(0.0, 0.0, 0.0, 0.0)
        # load = 3.5 sine / stiffness, and down = (load - sine) / cosine.
        drag = (2.5 - model.sine) * model.cloth_friction * model.cosine * slips.t
        change = load * load * drag / (3.5 * model.sine)
        n = -model.cloth_friction * (change * slips.n - load * slips.t)
        t = -model.cloth_friction * (change * slips.t + load * slips.n)
        return Friction(change / model.cosine, -(1.0 - 2.5 * model.sine) / 3.5 * t, n, t)
    grip = model.cloth_friction * load_of(-model.nose_friction * slips.down, model)
    return Friction(0.0, 0.0, grip * slips.t, -grip * slips.n)
