"""Which contact sticks during an impact of `cushion_mathavan2010`, the nose or the cloth."""

from __future__ import annotations

import math

from engine.core.kernel import kernel
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
    plus,
    rates_of,
    slips_of,
)

JAMMED = 3  # beside NEITHER, NOSE and CLOTH: both stick, and the ball can't leave

AT_LIMIT = 1e-6
"""What part of the square of what friction can hold counts as none; a slip errs by its square."""


@kernel
def settle(
    motion: Motion, held: int, still: float, head_start: float, model: Model
) -> tuple[Motion, int, bool]:
    """Decide which contact sticks from here on; return the motion, that, and whether they changed.

    A slip below `still` [m/s] has ended. It stays 0 where friction can hold it. Where it can't, and
    where a contact that stuck yields, the slip starts with a length that doesn't count, against the
    friction that would have held it; on the cloth that direction is exact, since the cloth's
    friction is the same in all, and the impulse `head_start` [m/s] is taken in it at once.
    """
    slips = slips_of(motion, model)
    nose_still = held == NOSE or (model.nose_friction > 0.0 and slips.nose <= still)
    cloth_still = held == CLOTH or (
        slips.cloth <= still
        and model.cloth_friction > 0.0
        and (nose_still or load_of(-model.nose_friction * slips.down, model) > 0.0)
    )
    if nose_still and cloth_still:
        motion, held = _leave_corner(motion, still, model)
        return motion, held, True
    if not (nose_still or cloth_still):
        return motion, NEITHER, False
    contact = NOSE if nose_still else CLOTH
    if margin_of(slips, contact, model) > AT_LIMIT:
        if held == contact:
            return motion, held, False
        return _with_slip(motion, contact, 0.0, 0.0, model), contact, True
    friction = friction_of(slips, contact, model)
    x = friction.down if nose_still else friction.n
    y = friction.along if nose_still else friction.t
    if x == math.inf:
        x, y = 1.0, 0.0
    start = -4.0 * still / math.sqrt(x * x + y * y)
    motion = _with_slip(motion, contact, start * x, start * y, model)
    if contact == CLOTH:
        motion = plus(motion, head_start, rates_of(motion, NEITHER, model))
    return motion, NEITHER, True


@kernel
def _with_slip(motion: Motion, contact: int, x: float, y: float, model: Model) -> Motion:
    """Return the motion after the impulse at a contact that gives it this slip."""
    sine = model.sine
    cross = 1.0 - 2.5 * sine
    if contact == NOSE:
        push = (x - motion.down) / (2.5 + sine * sine)
        along = model.along + 3.5 * motion.nose_t + cross * motion.cloth_t
        nose_t = motion.nose_t + (y - along) / 3.5
        return Motion(motion.vn + sine * push, x, nose_t, motion.cloth_t, motion.work)
    push = (x - ((1.0 + sine) * motion.vn - motion.down)) / 3.5
    skid = model.skid + cross * motion.nose_t + 3.5 * motion.cloth_t
    cloth_t = motion.cloth_t + (y - skid) / 3.5
    down = motion.down - (2.5 - sine) * push
    return Motion(motion.vn + push, down, motion.nose_t, cloth_t, motion.work)


@kernel
def _leave_corner(motion: Motion, still: float, model: Model) -> tuple[Motion, int]:
    """Decide how a ball leaves that neither moves nor slips anywhere.

    Jammed, if both contacts can hold it; else it slips at one, if the other can hold; else at both.
    """
    sine, cosine = model.sine, model.cosine
    nose_t, cloth_t, work = motion.nose_t, motion.cloth_t, motion.work
    jam = cosine / (1.0 + sine)
    if model.nose_friction >= jam and model.cloth_friction >= jam:
        return Motion(0.0, 0.0, nose_t, cloth_t, work), JAMMED
    vn = -4.0 * still / (1.0 + sine)
    down, load = hold_at_nose(-1.0, model)
    if abs(down) < model.nose_friction and sine * down + model.cloth_friction * load < cosine:
        return Motion(vn, 0.0, nose_t, cloth_t, work), NOSE
    n = (cosine + (2.5 - sine) * model.nose_friction) / 3.5
    if n < model.cloth_friction * load_of(model.nose_friction, model):
        return Motion(vn, (1.0 + sine) * vn, nose_t, cloth_t, work), CLOTH
    return Motion(vn, 0.5 * (1.0 + sine) * vn, nose_t, cloth_t, work), NEITHER


@kernel
def margin_of(slips: Slips, held: int, model: Model) -> float:
    """Return what part of the friction, squared, the contact that sticks has in reserve."""
    if held == NEITHER:
        return 1.0
    friction = friction_of(slips, held, model)
    if held == NOSE:
        limit = model.nose_friction * model.nose_friction
        needed = friction.down * friction.down + friction.along * friction.along
    else:
        grip = model.cloth_friction * load_of(friction.down, model)
        limit = grip * grip
        needed = friction.n * friction.n + friction.t * friction.t
    if needed == 0.0:
        return 1.0
    return 1.0 - needed / limit if needed < 1e12 * limit else -1e12
