"""A cushion whose impact is followed through its impulse, with friction at the nose and the cloth.

Mathavan, S., Jackson, M. R. and Parkin, R. M. (2010): A theoretical analysis of billiard ball
dynamics under cushion impacts. Proc. IMechE C, J. Mechanical Engineering Science 224(9), 1863-1873.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from engine.core.kernel import kernel
from engine.core.state import Laws
from engine.impacts.laws._mathavan2010_contacts import AT_LIMIT, JAMMED, margin_of, settle
from engine.impacts.laws._mathavan2010_steps import (
    CLOTH,
    NEITHER,
    NOSE,
    Model,
    Motion,
    Slips,
    friction_of,
    hold_at_nose,
    load_of,
    rates_of,
    slips_of,
    smooth_step,
    stiff_step,
)
from engine.impacts.laws.interface import CushionBounce, CushionImpact

_COMPRESSION = 0
_REBOUND = 1

# Tolerances, beside `AT_LIMIT`. The first three are in units of the speed of approach.
_STEP_ERROR = 3e-11  # of a step, as estimated
_STILL = 1e-11  # a slip below this counts as none
_TURNED = 1e-10  # compression ends below this; the work then errs by the square of it
_ROUNDING = 1e-14  # of all speeds together: added to the first two
_RETURNED = 1e-13  # of the work to be returned; or what gives no speed that counts
# Below either approach the ball only bounces: what friction would change is lost in rounding.
_LEAST = 1e-140  # [m/s]; the squares of smaller speeds vanish
_GRAZING = 1e-13  # of all speeds together

# A step of the implicit method knows the stiffness at its start; slips may grow by this in one.
_GROWTH = 8.0
_SAFETY = 0.85
# Bounds of the work. Most impacts take 5 to 100 steps; the longest of 200 000 took 723.
_MOST_STEPS = 10_000
_MOST_TRIES = 60  # of one step


class _Scales(NamedTuple):
    """Speeds [m/s] of an impact that its numerical errors are measured in."""

    approach: float
    still: float
    error: float


class _Stride(NamedTuple):
    """Impulses [m/s] that were good for the last steps of either method."""

    smooth: float
    stiff: float


@kernel
def mathavan2010(impact: CushionImpact, laws: Laws) -> CushionBounce:
    """Return the bounce off a nose at `laws.cushion_height`, by Mathavan's law.

    Parameters
    ----------
    impact : CushionImpact
        The ball when it touches the cushion [m/s, rad/s, m, kg]; the mass cancels. `cloth` is the
        coefficient of friction between ball and cloth.
    laws : Laws
        `cushion_restitution` in [0, 1], `cushion_friction` >= 0, and `cushion_height`, above the
        cloth and below the top of the ball [m].

    Returns
    -------
    CushionBounce
        The ball after the impact [m/s, rad/s]; not a number, which the engine reports, should the
        bound of the work ever be met.

    Notes
    -----
    Contract: no allocation; a bounded number of steps; energy does not rise; vn <= 0 afterwards;
    mirrored along the cushion, and with speeds times a power of two, the same to the bit.

    The paper's equations of motion with x = -t and y = n, in the impulse of the nose. The nose
    pushes along its normal and rubs against the ball's slip there; the ball keeps to the cloth,
    whose load follows from that, and the cloth rubs too. Compression ends when vn = 0, and the
    rebound when the work that the nose gave back is e^2 of what it took. What the paper leaves
    open:

    - A slip that ends stays 0 while friction can hold it, and starts again where it can't. The
      paper's ratio of components has no value there, and a fixed step chatters.
    - The cloth can't pull. Where the nose lifts the ball (topspin, a nose below mid-ball), the load
      would be negative and the cloth would drive the slip. It is 0 there, and so is its friction.
    - A ball may jam: both contacts can hold it (coefficients of at least cosine / (1 + sine) of the
      angle of the nose), or the cloth outweighs the nose's push as the ball leaves. Then it ends
      with vn = 0, and what work was stored is lost.

    Energy: of what acts on the ball, both frictions take it, what is vertical does no work, and the
    nose gives back at most what it took.

    Accuracy: steps are chosen so that each errs by less than 3e-11 of the speed of approach, as
    estimated, and land on the ends of slips, of what friction can hold and of the phases. The
    outcome errs by less than 1e-9 of the speed of approach and 1e-12 of all speeds, but where both
    slips nearly end at once, as before a jam: there the motion itself magnifies what is small.
    """
    radius, vn = impact.radius, impact.vn
    speeds = vn + abs(impact.vt) + radius * (abs(impact.wn) + abs(impact.wt) + abs(impact.wz))
    if vn < _LEAST or vn < _GRAZING * speeds:
        vn = -laws.cushion_restitution * vn
        return CushionBounce(vn, impact.vt, impact.wn, impact.wt, impact.wz)
    sine = (laws.cushion_height - impact.radius) / impact.radius
    cosine = math.sqrt((1.0 - sine) * (1.0 + sine))
    along = impact.vt + radius * (impact.wz * cosine - impact.wn * sine)
    skid = impact.vt + radius * impact.wn
    planar = along == 0.0 and skid == 0.0
    model = Model(sine, cosine, laws.cushion_friction, impact.cloth, along, skid, planar)
    rounding = _ROUNDING * speeds
    scales = _Scales(vn, _STILL * vn + 0.2 * rounding, _STEP_ERROR * vn + rounding)
    before = Motion(vn, vn * sine + radius * impact.wt, 0.0, 0.0, 0.0)
    after = _follow(before, laws.cushion_restitution, scales, model)
    turn = 2.5 / radius  # m R / I
    return CushionBounce(
        min(after.vn, 0.0),
        impact.vt + (after.nose_t + after.cloth_t),
        impact.wn + turn * (after.cloth_t - sine * after.nose_t),
        impact.wt + ((after.down - before.down) - sine * (after.vn - vn)) / radius,
        impact.wz + turn * (cosine * after.nose_t),
    )


@kernel
def _follow(motion: Motion, e: float, scales: _Scales, model: Model) -> Motion:
    """Return the motion at the end of the impact."""
    turned = _TURNED * scales.approach
    fresh = _Stride(0.3 * scales.approach, 0.03 * scales.approach)
    stride = fresh
    held, phase, slack = NEITHER, _COMPRESSION, 0.0
    for _ in range(_MOST_STEPS):
        # None in the rebound, and in compression not past its end.
        head_start = max(0.0, min(1e-6 * scales.approach, 0.25 * motion.vn))
        motion, now, moved = settle(motion, held, scales.still, head_start, model)
        if moved:
            # A slip that starts grows from nothing; steps grow with it.
            stiff = 1e-5 * scales.approach if now == NEITHER else fresh.stiff
            stride = _Stride(fresh.smooth, stiff)
        held = now
        if held == JAMMED:
            return motion
        if phase == _COMPRESSION and motion.vn <= turned:
            # From here on the work counts what is still to be returned.
            phase = _REBOUND
            motion = Motion(
                motion.vn, motion.down, motion.nose_t, motion.cloth_t, e * e * motion.work
            )
            slack = max(_RETURNED * motion.work, _STILL * turned * scales.approach)
        if phase == _REBOUND and (motion.work <= slack or _returns(motion, held, turned, model)):
            return motion
        motion, stride = _advance(motion, held, phase, slack, stride, scales, model)
    return Motion(math.nan, math.nan, math.nan, math.nan, math.nan)


@kernel
def _returns(motion: Motion, held: int, turned: float, model: Model) -> bool:
    """Return whether the ball, on its way out, is driven back into the cushion."""
    return motion.vn > -turned and rates_of(motion, held, model).vn >= 0.0


@kernel
def _advance(
    motion: Motion,
    held: int,
    phase: int,
    slack: float,
    stride: _Stride,
    scales: _Scales,
    model: Model,
) -> tuple[Motion, _Stride]:
    """Take one step that is accurate enough and passes no event; return what comes after it.

    The explicit method where it is stable, unless the implicit one gets much further.
    """
    slips = slips_of(motion, model)
    reach, growth = _reach(motion, slips, held, phase, model)
    cap = _stable(slips, held, model)
    h = min(stride.smooth, cap, reach)
    implicit = min(stride.stiff, growth, reach)
    stiff = implicit > 4.0 * h
    if stiff:
        h = implicit
    free = stride.stiff if stiff else stride.smooth
    margin = margin_of(slips, held, model)
    end, ends, scale, yields = motion, slips, 0.0, False
    for _ in range(_MOST_TRIES):
        if stiff:
            end, error = stiff_step(motion, h, held, model)
        else:
            end, error = smooth_step(motion, h, held, model)
        scale = _rescale(error, stiff, scales)
        if scale < _SAFETY:
            h *= max(0.1, scale)
            free = h
            continue
        ends = slips_of(end, model)
        grown = _growth(slips, ends, held, model) if stiff else 1.0
        if grown > 1.2 * _GROWTH:
            h *= max(0.05, math.sqrt(_GROWTH / grown))
            free = h
            continue
        part = _part_before_end(motion, end, phase, slack, scales)
        before_limit = _part_before_limit(margin, margin_of(ends, held, model))
        yields = yields or before_limit < 1.0
        part = min(part, before_limit, _part_before_reversal(slips, ends, held, scales, model))
        if part == 1.0:
            if yields:
                # What is left until the contact yields is short.
                return end, _Stride(0.05 * h, 0.05 * h)
            if stiff and h < growth:
                # A slip that starts slowly grows with the square of the impulse: 2.8^2 is 8.
                scale = min(scale, 2.8)
            free = max(free, h * scale) if h < free else h * scale
            free *= _shrinking(slips, ends, held)
            if stiff:
                return end, _Stride(max(stride.smooth, h), free)
            # While only stability limits it, let the implicit method try more and more.
            return end, _Stride(free, 1.25 * max(stride.stiff, h) if h == cap else stride.stiff)
        # A little short of it, so that the next step is a short one that lands on it.
        h *= 0.98 * part
    return Motion(math.nan, math.nan, math.nan, math.nan, math.nan), stride


@kernel
def _rescale(error: Motion, stiff: bool, scales: _Scales) -> float:
    """Return by how much a step may be longer, for its error: below `_SAFETY` it wasn't accurate.

    Square roots stand for the roots of order 5 1/3 and 8.
    """
    size = abs(error.vn) + abs(error.down) + abs(error.nose_t) + abs(error.cloth_t)
    size = (size + abs(error.work) / scales.approach) / scales.error
    if not size < 1e12:  # or not a number
        return 0.0
    if size < 1e-12:
        return 5.0
    root = math.sqrt(math.sqrt(size))
    root = root / math.sqrt(math.sqrt(root)) if stiff else math.sqrt(root)
    return min(5.0, _SAFETY / root)


@kernel
def _growth(slips: Slips, ends: Slips, held: int, model: Model) -> float:
    """Return by how much the slip that grew most is longer; 1 in a plane, where none turns."""
    grown = 1.0
    if not model.planar:
        if held != NOSE and slips.nose > 0.0:
            grown = max(grown, ends.nose / slips.nose)
        if held != CLOTH and slips.cloth > 0.0:
            grown = max(grown, ends.cloth / slips.cloth)
    return grown


@kernel
def _shrinking(slips: Slips, ends: Slips, held: int) -> float:
    """Return by how much the slip that shrank most is shorter: steps shrink with it."""
    shrunk = 1.0
    if held != NOSE and ends.nose < slips.nose:
        shrunk = ends.nose / slips.nose
    if held != CLOTH and ends.cloth < slips.cloth:
        shrunk = min(shrunk, ends.cloth / slips.cloth)
    return shrunk


@kernel
def _part_before_end(
    motion: Motion, end: Motion, phase: int, slack: float, scales: _Scales
) -> float:
    """Return what part of a step stays in the phase, were all linear; 1 where all of it does."""
    turned = _TURNED * scales.approach
    part = 1.0
    if phase == _COMPRESSION:
        if end.vn < -turned:
            part = motion.vn / (motion.vn - end.vn)
        return part
    if end.work < -slack:
        part = motion.work / (motion.work - end.work)
    if end.vn > turned and motion.vn < 0.0:
        part = min(part, motion.vn / (motion.vn - end.vn))
    return part


@kernel
def _part_before_limit(margin: float, after: float) -> float:
    """Return what part of a step keeps within the friction, were all linear; 1: all of it."""
    return margin / (margin - after) if after < -AT_LIMIT else 1.0


@kernel
def _part_before_reversal(
    slips: Slips, ends: Slips, held: int, scales: _Scales, model: Model
) -> float:
    """Return what part of a step reverses no slip that friction acts on, were all linear; 1: all.

    The estimate of the error can't be relied on here: no rate is evaluated beyond the reversal
    where that comes late in the step.
    """
    part = 1.0
    if (
        held != NOSE
        and model.nose_friction > 0.0
        and slips.nose > scales.still
        and slips.down * ends.down + slips.along * ends.along < 0.0
    ):
        part = slips.nose / (slips.nose + ends.nose)
    loaded = held == NOSE or load_of(-model.nose_friction * ends.down, model) > 0.0
    if (
        held != CLOTH
        and loaded
        and model.cloth_friction > 0.0
        and slips.cloth > scales.still
        and slips.n * ends.n + slips.t * ends.t < 0.0
    ):
        part = min(part, slips.cloth / (slips.cloth + ends.cloth))
    return part


@kernel
def _stable(slips: Slips, held: int, model: Model) -> float:
    """Return the longest stable step of the explicit method: a slip over what friction does to it.

    In a plane no slip turns, and nothing can become unstable.
    """
    if model.planar:
        return math.inf
    rate = 0.0
    if held != NOSE and slips.nose > 0.0:
        rate = 3.5 * model.nose_friction / slips.nose
    if held != CLOTH and slips.cloth > 0.0:
        load = load_of(-model.nose_friction * slips.down, model)
        if held == NOSE:
            _, load = hold_at_nose(slips.n, model)
        rate = max(rate, 3.5 * model.cloth_friction * load / slips.cloth)
    return 2.0 / rate if rate > 0.0 else math.inf


@kernel
def _reach(
    motion: Motion, slips: Slips, held: int, phase: int, model: Model
) -> tuple[float, float]:
    """Return the longest step before a slip or the phase ends, and that in which no slip outgrows.

    As the rates are now; what comes out is checked.
    """
    friction = friction_of(slips, held, model)
    sine, cosine = model.sine, model.cosine
    cross = 1.0 - 2.5 * sine
    reach, growth = math.inf, math.inf
    if held != NOSE and model.nose_friction > 0.0:
        down = (2.5 + sine * sine) * friction.down - (2.5 - sine) * friction.n - sine * cosine
        along = 3.5 * friction.along + cross * friction.t
        reach, growth = _until_still(slips.nose, slips.down, slips.along, down, along)
    if held != CLOTH and model.cloth_friction * load_of(friction.down, model) > 0.0:
        n = 3.5 * friction.n - (2.5 - sine) * friction.down - cosine
        t = cross * friction.along + 3.5 * friction.t
        until, most = _until_still(slips.cloth, slips.n, slips.t, n, t)
        reach, growth = min(reach, until), min(growth, most)
    if model.planar:
        growth = math.inf
    slowing = cosine - sine * friction.down - friction.n
    if phase == _COMPRESSION:
        if slowing > 0.0:
            reach = min(reach, motion.vn / slowing)
    elif slowing > 0.0:
        # cosine (slowing h^2 / 2 - vn h) = work
        away = max(0.0, -motion.vn)
        root = math.sqrt(away * away + 2.0 * slowing * motion.work / cosine)
        reach = min(reach, 2.0 * motion.work / (cosine * (root + away)))
    elif slowing < 0.0 and motion.vn < 0.0:
        reach = min(reach, motion.vn / slowing)
    return reach, growth


@kernel
def _until_still(slip: float, x: float, y: float, dx: float, dy: float) -> tuple[float, float]:
    """Return the step after which a slip has nearly ended, and that in which it outgrows.

    The more it moves aside, the less of it is known to end.
    """
    closing = -(x * dx + y * dy)
    if closing < 0.0:
        return math.inf, slip * (_GROWTH - 1.0) / -closing
    if closing == 0.0:
        return math.inf, math.inf
    aside = abs(x * dy - y * dx) / closing
    return slip / closing * (1.0 - min(0.25, 4.0 * aside + 1e-9)), math.inf
