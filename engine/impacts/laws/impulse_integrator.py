"""Integration, over the normal impulse, of an impact with friction at two contacts.

The equations are in `two_contacts`. While both contacts slip, steps are those of `smooth_slips`.
The shorter a slip, the faster it turns, and a slip that is held by friction is stiff. There the
method is implicit; steps become short automatically when a contact starts or stops to slip.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ghostball.engine.core.kernel import kernel
from ghostball.engine.impacts.laws.smooth_slips import Step, begun, is_smooth, smooth_step
from ghostball.engine.impacts.laws.two_contacts import (
    TURNS,
    Held,
    Model,
    Outcome,
    Slips,
    approach_change_of,
    drift_of,
    held_of,
    length,
    outcome_of,
    per_slip,
    plus,
    rates_of,
    speed_rate_of,
)

STILL = 4e-9
"""Slip below which friction is proportional to the slip and holds it.

With this rule, no code has to decide when a contact sticks or starts to slip. A held contact moves
by less than this.
"""

_STEP_ERROR = 1e-10  # estimated error of the slips in one step, if one of them is short
_LONG = 16.0  # factor on _STEP_ERROR per length of the shorter slip, if neither is near its end
_ROUNDING = 2.0**-44  # relative to the sum of all speeds: added to `STILL` and `_STEP_ERROR`
_TURNED = 1e-8  # speed below which compression ends; the error of the work is its square
_RETURNED = 1e-8  # part of the work to be returned that one step at constant rates may return
_WORK_ROUNDING = 1e-15  # relative to the stored work; it corresponds to a speed of 3e-8
_FIRST_STEP = 0.25
_STANDS = 1e-2  # rate of the approach speed that counts as 0 if both contacts hold
_SMOOTH_STEPS = 128  # number of steps after which all are implicit; any smooth impact needs fewer
# Most impacts take 15 to 25 steps, and up to 400 if a slip ends. A contact at the limit of what it
# can hold may alternately slip and be held; then the limit `STILL` is raised. After the last step
# the result is NaN, and the run fails.
_WIDEN_AFTER = 500
_MOST_STEPS = 10_000


class _Matrix(NamedTuple):
    """A 2 x 2 matrix, row by row."""

    a: float
    b: float
    c: float
    d: float


class _Solver(NamedTuple):
    """The matrix 1 - h gamma J, J the Jacobian, in blocks for the two contacts, factorised."""

    schur: _Matrix  # inverse of the Schur complement of the lower right block
    upper: _Matrix  # the upper right block times the inverse of the lower right block
    lower: _Matrix
    last: _Matrix  # the inverse of the lower right block


@kernel
def _times(m: _Matrix, other: _Matrix) -> _Matrix:
    return _Matrix(
        m.a * other.a + m.b * other.c,
        m.a * other.b + m.b * other.d,
        m.c * other.a + m.d * other.c,
        m.c * other.b + m.d * other.d,
    )


@kernel
def _inverse(m: _Matrix) -> _Matrix:
    over = 1.0 / (m.a * m.d - m.b * m.c)
    return _Matrix(over * m.d, -over * m.b, -over * m.c, over * m.a)


@kernel
def _stiffness(x: float, y: float, gain: float, held: bool, still: float) -> _Matrix:
    """Return the Jacobian of the friction -gain (x, y) / |(x, y)| of a slip (x, y)."""
    over = per_slip(x, y, held, still)
    gain *= over
    if held:
        return _Matrix(-gain, 0.0, 0.0, -gain)
    x, y = over * x, over * y
    return _Matrix(-gain * y * y, gain * x * y, gain * x * y, -gain * x * x)


@kernel
def _solver(change: Slips, h: float, held: Held, model: Model) -> _Solver:
    """Return 1 - h J, factorised; J is the Jacobian of the rates."""
    slips = plus(model.start, 1.0, change)
    share = -model.friction * per_slip(slips.across, slips.along, held.contact, held.still)
    load = max(model.load + model.load_across * share * slips.across, 0.0)
    gain = h * model.cloth_friction * load
    f = _stiffness(slips.across, slips.along, h * model.friction, held.contact, held.still)
    g = _stiffness(slips.n, slips.t, gain, held.cloth, held.still)
    # The contact's friction loads the cloth, whose friction is proportional to the load.
    gain = model.cloth_friction * model.load_across if load > 0.0 else 0.0
    gain *= per_slip(slips.n, slips.t, held.cloth, held.still)
    n, t = -gain * slips.n, -gain * slips.t
    loaded = _Matrix(n * f.a, n * f.b, t * f.a, t * f.b)
    across, along = model.across_cloth, model.along_cloth
    first = _Matrix(
        1.0 - model.across * f.a - across * loaded.a,
        -model.across * f.b - across * loaded.b,
        -TURNS * f.c - along * loaded.c,
        1.0 - TURNS * f.d - along * loaded.d,
    )
    lower = _Matrix(
        -model.n_across * f.a - TURNS * loaded.a,
        -model.n_across * f.b - TURNS * loaded.b,
        -model.t_along * f.c - TURNS * loaded.c,
        -model.t_along * f.d - TURNS * loaded.d,
    )
    last = _inverse(_Matrix(1.0 - TURNS * g.a, -TURNS * g.b, -TURNS * g.c, 1.0 - TURNS * g.d))
    upper = _times(_Matrix(-across * g.a, -across * g.b, -along * g.c, -along * g.d), last)
    less = _times(upper, lower)
    schur = _inverse(
        _Matrix(first.a - less.a, first.b - less.b, first.c - less.c, first.d - less.d)
    )
    return _Solver(schur, upper, lower, last)


_GAMMA = 0.25


@kernel
def _stage(at: Slips, of: Slips, h: float, solver: _Solver, held: Held, model: Model) -> Slips:
    """Return gamma (h rates + of), multiplied by the inverse of 1 - h gamma J."""
    r = plus(of, h, rates_of(at, held, model))
    schur, upper, lower, last = solver
    x, y = r.across - (upper.a * r.n + upper.b * r.t), r.along - (upper.c * r.n + upper.d * r.t)
    x, y = schur.a * x + schur.b * y, schur.c * x + schur.d * y
    n, t = r.n - (lower.a * x + lower.b * y), r.t - (lower.c * x + lower.d * y)
    n, t = last.a * n + last.b * t, last.c * n + last.d * t
    x, y, n, t = _GAMMA * x, _GAMMA * y, _GAMMA * n, _GAMMA * t
    work = _GAMMA * (r.work + h * approach_change_of(Slips(x, y, n, t, 0.0, 0.0), model))
    return Slips(x, y, n, t, _GAMMA * r.p, work)


@kernel
def _step(change: Slips, h: float, held: Held, model: Model) -> tuple[Slips, float]:
    """Return the slips after an impulse h, and an estimate of their error.

    RODAS, a stiffly accurate Rosenbrock method of order 4, with order 3 for the estimate (Hairer
    and Wanner 1996, Solving ordinary differential equations II, section IV.7). Near its end a slip
    turns faster the shorter it is, and a held slip is stiff, by 1 / `STILL`.
    """
    solver = _solver(change, _GAMMA * h, held, model)
    none = Slips(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    a = _stage(change, none, h, solver, held, model)
    at = plus(change, 1.544, a)
    b = _stage(at, plus(none, -5.6688, a), h, solver, held, model)
    at = plus(plus(change, 0.9466785280815826, a), 0.2557011698983284, b)
    of = plus(plus(none, -2.430093356833875, a), -0.2063599157091915, b)
    c = _stage(at, of, h, solver, held, model)
    at = plus(plus(change, 3.314825187068521, a), 2.896124015972201, b)
    at = plus(at, 0.9986419139977817, c)
    of = plus(plus(none, -0.1073529058151375, a), -9.594562251023355, b)
    d = _stage(at, plus(of, -20.47028614809616, c), h, solver, held, model)
    at = plus(plus(change, 1.221224509226641, a), 6.019134481288629, b)
    at = plus(plus(at, 12.53708332932087, c), -0.6878860361058950, d)
    of = plus(plus(none, 7.496443313967647, a), -10.24680431464352, b)
    of = plus(plus(of, -33.99990352819905, c), 11.70890893206160, d)
    e = _stage(at, of, h, solver, held, model)
    at = plus(at, 1.0, e)
    of = plus(plus(none, 8.083246795921522, a), -7.981132988064893, b)
    of = plus(plus(of, -31.52159432874371, c), 16.31930543123136, d)
    error = _stage(at, plus(of, -6.058818238834054, e), h, solver, held, model)
    end = plus(at, 1.0, error)
    slips = plus(model.start, 1.0, end)
    contact, cloth = length(slips.across, slips.along), length(slips.n, slips.t)
    size = max(length(error.across, error.along), length(error.n, error.t))
    size = size / (1.0 + _LONG * min(contact, cloth))
    return end, max(size, abs(error.work) / (1.0 + _LONG * (contact + cloth)))


@kernel
def _missed(change: Slips, end: Slips, h: float, held: Held, model: Model) -> float:
    """Return the length of a slip whose start or reversal a step has missed.

    A held slip starts if friction doesn't hold it at the end of the step. A slip reverses if it
    passes through 0; its friction then reverses, too.
    """
    now = held_of(end, held.still, model)
    rates = rates_of(end, now, model)
    slips, ends = plus(model.start, 1.0, change), plus(model.start, 1.0, end)
    missed = 0.0
    if not now.contact:
        if held.contact:
            missed = h * length(rates.across, rates.along)
        elif slips.across * ends.across + slips.along * ends.along < 0.0:
            missed = length(ends.across, ends.along)
    if not now.cloth:
        if held.cloth:
            missed = max(missed, h * length(rates.n, rates.t))
        elif slips.n * ends.n + slips.t * ends.t < 0.0:
            missed = max(missed, length(ends.n, ends.t))
    return missed


@kernel
def _until_still(change: Slips, held: Held, model: Model) -> float:
    """Return the impulse after which a slip would nearly have ended if the rates were constant."""
    slips, rates = plus(model.start, 1.0, change), rates_of(change, held, model)
    until = math.inf
    closing = -(slips.across * rates.across + slips.along * rates.along)
    if closing > 0.0 and not held.contact:
        until = (slips.across * slips.across + slips.along * slips.along) / closing
    closing = -(slips.n * rates.n + slips.t * rates.t)
    if closing > 0.0 and not held.cloth:
        until = min(until, (slips.n * slips.n + slips.t * slips.t) / closing)
    return 0.999 * until


@kernel
def _stiff_step(change: Slips, p: float, held: Held, allowed: float, model: Model) -> Step:
    """Return the slips after an impulse p, with an estimated error up to `allowed`."""
    end, error = _step(change, p, held, model)
    growth = 0.8 * math.sqrt(math.sqrt(allowed / max(error, 1e-3 * allowed)))
    missed = _missed(change, end, p, held, model)
    is_right = error <= allowed and missed <= held.still
    if not is_right:
        least = 0.5 * held.still / max(missed, 1e-3 * held.still)
        growth = max(0.1 * growth, min(growth, least))
    return Step(end, growth, is_right)


@kernel
def integrate(model: Model, speeds: float) -> Outcome:
    """Return the impulses of an impact.

    `speeds`: sum of all speeds; its rounding limits the accuracy of the result.

    The error of the result is below 1e-7, plus the rounding of `speeds`.

    Compression ends when the approach speed is 0. The rebound ends when the normal force has
    returned e^2 of the work that it stored, the integral of the approach speed (Stronge), or if the
    ball is driven back. Either phase ends if both contacts hold the ball and it doesn't move: then
    it is jammed.

    Contract: no allocation; a bounded number of steps. Mirrored (`along` and `t`), the result is
    mirrored to the bit.
    """
    rounding = _ROUNDING * speeds
    still, allowed = STILL + rounding, _STEP_ERROR + rounding
    start = begun(model.start, rounding, model)
    change = plus(start, -1.0, model.start)
    speed, work, rounding = 1.0, 0.0, 0.0
    rebound, drift = False, drift_of(model)
    held = held_of(change, still, model)
    rate = speed_rate_of(change, held, model)
    free = _FIRST_STEP
    for step in range(1, _MOST_STEPS):
        if step % _WIDEN_AFTER == 0:
            still *= 2.0
            held = held_of(change, still, model)
        until = _reach(speed, rate, work, rebound)
        if step < _SMOOTH_STEPS and is_smooth(plus(model.start, 1.0, change), model):
            h = min(free, until)
            end, growth, is_right = smooth_step(change, h, allowed, model)
        else:
            h = min(free, until, _until_still(change, held, model))
            end, growth, is_right = _stiff_step(change, h, held, allowed, model)
        if not is_right:
            free = h * growth
            continue
        now = 1.0 + drift * end.p + approach_change_of(end, model)
        if rebound and now > _TURNED and speed >= -_TURNED:
            return outcome_of(change, speed, model)
        if (now > _TURNED) if rebound else (now < -_TURNED):
            free = h * (speed / (speed - now))
            continue
        held_then = held_of(end, still, model)
        then = speed_rate_of(end, held_then, model)
        mean = 1.0 + 0.5 * drift * (change.p + end.p)
        done = (end.p - change.p) * mean + (end.work - change.work)
        if rebound and work + done < -rounding:
            free = h * (work / -done)
            continue
        free = max(h * growth, free if h < free else 0.0)
        change, speed, work, rate, held = end, now, work + done, then, held_then
        if speed <= _TURNED and not rebound:
            rebound = True
            rounding = _WORK_ROUNDING * (1.0 + work)
            work *= model.restitution * model.restitution
            rounding += _RETURNED * work
        if rebound and work <= rounding:
            if work != 0.0:
                left = _reach(speed, rate, work, rebound)
                change = plus(change, left, rates_of(change, held, model))
                speed += left * rate
            return outcome_of(change, speed, model)
        driven_back = rebound and speed >= -_TURNED and rate >= 0.0
        if driven_back or (held.contact and held.cloth and rate > -_STANDS):
            return outcome_of(change, speed, model)
    nan = math.nan
    return Outcome(nan, nan, Slips(nan, nan, nan, nan, nan, nan))


@kernel
def _reach(speed: float, rate: float, work: float, rebound: bool) -> float:
    """Return the impulse to the end of the phase if the rate of the speed were constant."""
    if not rebound:
        return max(-speed / rate, 1e-12) if rate < 0.0 else math.inf
    away = max(-speed, 0.0)
    square = away * away - 2.0 * rate * work
    return 2.0 * work / (away + math.sqrt(square)) if square > 0.0 else -speed / rate
