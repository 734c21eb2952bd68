"""The order in which an engine's error falls with its step, and the time to reach an accuracy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict

from ghostball.validation.bench._extrapolation import (
    FEWEST_LEVELS,
    WHOLE_ORDERS,
    Extrapolation,
    extrapolate,
)

FloatArray = NDArray[np.float64]

TARGETS = (1e-3, 1e-6, 1e-9)
"""Accuracies whose time is told [m]: what an eye, a gauge, and nobody sees."""

ROUNDING = 2.0**-53
"""What a step may add to an error by rounding [m]: positions on a table are below 2 m or so.

Steps that change a speed by the same amount again and again are all rounded the same way, so that
n steps may add n times that, and halving the step doubles it.
"""

NO_STEP = "no step: a point"
"""Why an exact engine has no order."""

LIMIT_PART = 0.5
"""The least part of the finest step's error by which a limit is surely beside the truth.

One power of the step is fitted where there are others: they move a limit by less.
"""

How = Literal["measured", "extrapolated", "never"]


class Reach(BaseModel):
    """How long an engine takes for an accuracy.

    Attributes
    ----------
    target : float [m]
    seconds : float or None [s]
        None where it is never reached.
    how : "measured", "extrapolated" or "never"
        Measured: that run, and all that were tried with a finer step, are as near as that from
        every phase; none of these failed. Extrapolated: no run is, but the error falls by the
        fitted order.
    note : str
        Why it is never reached, or at which step it is expected to be; else "".
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    target: float
    seconds: float | None = None
    how: How
    note: str = ""


@dataclass(frozen=True, eq=False)
class Level:
    """One point of a ladder, as far as its order and its reach depend on it.

    Attributes
    ----------
    step : float or None [s]
    seconds : float [s]
    worst : float [m]
        The largest error over the start phases.
    states : (p, n, 2) float64 [m]
        Where the balls end, from each of the p phases in which it began.
    true_course : bool
        Whether in all of these those met that meet in truth.
    """

    step: float | None
    seconds: float
    worst: float
    states: FloatArray
    true_course: bool = True


@dataclass(frozen=True, eq=False)
class Order:
    """What a ladder says of the order.

    Attributes
    ----------
    note : str
        Which orders would fit as well; or why there is none.
    value : float or None [1]
        As fitted; None where there is none, or several whole ones fit.
    power : float or None [1]
        That of the step by which errors are extrapolated: the lowest whole order that fits, else,
        since errors of steps grow in whole powers, the next whole one below; None for none.
    beside : float [m]
        How far the limit is surely beside the truth.
    """

    note: str
    value: float | None = None
    power: float | None = None
    beside: float = 0.0


def order_of(levels: Sequence[Level], truth: FloatArray) -> Order:
    """Fit the order of a ladder, from its finest steps up to the last that plays the true course.

    Parameters
    ----------
    levels : sequence of Level
        The longest step first.
    truth : (n, 2) float64 [m]
    """
    if not levels or levels[0].step is None:
        return Order(NO_STEP)
    kept: list[Level] = []
    for level in reversed(levels):
        if not level.true_course:
            break
        kept.insert(0, level)
    if len(kept) < FEWEST_LEVELS:
        return Order(
            f"no order: {len(kept)} steps play the true course, and it takes {FEWEST_LEVELS}"
        )
    fit = extrapolate(
        [level.step for level in kept if level.step is not None],
        [level.states[: _evenly_spread(len(level.states))] for level in kept],
        truth,
    )
    return _order(fit, _beside(fit, truth, kept[-1].worst))


def _evenly_spread(count: int) -> int:
    """Return how many of the first phases are spread evenly: the largest power of two."""
    return 1 << (count.bit_length() - 1)


def _beside(fit: Extrapolation, truth: FloatArray, finest: float) -> float:
    """Return how far the limit is surely beside the truth [m]."""
    beside = float(np.max(np.hypot(*(fit.limit - truth).T))) - fit.uncertainty
    return beside if beside > LIMIT_PART * finest else 0.0


def _order(fit: Extrapolation, beside: float) -> Order:
    if fit.outcome == "flat":
        return Order("no order: the step makes no difference")
    if fit.outcome == "not converged" or fit.order is None:
        return Order("no order: it goes to no limit, as far as the step was halved")
    assert fit.order_low is not None  # of every fit
    assert fit.order_high is not None
    whole = [p for p in WHOLE_ORDERS if fit.order_low <= p <= fit.order_high]
    limit = f"; its limit is {beside:.1e} m beside the truth" if beside else ""
    if len(whole) > 1:
        note = f"no order: all from {fit.order_low:.2f} to {fit.order_high:.2f} fit"
        return Order(note + limit, None, whole[0], beside)
    if whole:
        note = f"{fit.order_low:.2f} to {fit.order_high:.2f} fit"
        return Order(note + limit, fit.order, whole[0], beside)
    below = max((p for p in WHOLE_ORDERS if p <= fit.order), default=fit.order)
    return Order(f"by no whole power{limit}", fit.order, below, beside)


def reach_of(
    target: float,
    levels: Sequence[Level],
    order: Order,
    duration: float,
    accepts: Callable[[float], bool],
    lost: Sequence[float] = (),
) -> Reach:
    """Return how long an engine takes for an accuracy.

    Parameters
    ----------
    target : float [m]
    levels : sequence of Level
        The longest step first.
    order : Order
        As `order_of` returned for them.
    duration : float [s]
        Of the shot.
    accepts : callable
        Whether the engine accepts a step [s].
    lost : sequence of float [s]
        Steps at which a run failed or stopped early: nothing coarser than these counts.

    Notes
    -----
    A step that is good by luck counts only where all finer ones are as good. With the power p and
    the limit off by f at least, the error is taken as f + c h^p through the finest step, and the
    time as proportional to 1 / h. Where f is 0 that takes the truth for the limit: no fit could say
    so to a nanometre.
    """
    good: list[Level] = []
    for level in reversed(levels):
        if not level.worst <= target or _fails_finer(level, lost):
            break
        good.append(level)
    if good:
        seconds = min(level.seconds for level in good)
        return Reach(target=target, seconds=seconds, how="measured")
    if not levels:
        return Reach(target=target, how="never", note="nothing was measured")
    finest = levels[-1]
    if _fails_finer(finest, lost):
        note = f"it fails at finer steps, such as {min(lost):.1e} s"
        return Reach(target=target, how="never", note=note)
    if order.power is None or finest.step is None:
        return Reach(target=target, how="never", note=order.note)
    if target <= order.beside:
        note = f"its limit is {order.beside:.1e} m beside the truth"
        return Reach(target=target, how="never", note=note)
    left = (finest.worst - order.beside) / (target - order.beside)
    finer = max(left, 1.0) ** (1.0 / order.power)
    step = finest.step / finer
    if not accepts(step):
        return Reach(target=target, how="never", note=f"it refuses a step of {step:.1e} s")
    rounding = ROUNDING * duration / step
    if not rounding < target:
        note = f"{duration / step:.1e} steps may be off by {rounding:.1e} m by rounding alone"
        return Reach(target=target, how="never", note=note)
    return Reach(
        target=target,
        seconds=finest.seconds * finer,
        how="extrapolated",
        note=f"with a step of {step:.1e} s",
    )


def _fails_finer(level: Level, lost: Sequence[float]) -> bool:
    return level.step is not None and any(step < level.step for step in lost)
