"""Carries small perturbations of a shot along its recorded motion: the tangent map.

A perturbation of a ball is one of its position, velocity and angular velocity at an instant, to
first order. Between events it follows the derivative of the closed form
(`sensitivity.between_events`). An event h = 0 comes later for it by dtau = -(grad h . dz) / (grad h
. f), and takes it to dz+ = DG (dz- + f- dtau) - f+ dtau (saltation), f the rate of change before
and after, DG the derivative of what the event does (`sensitivity.through_impacts`).

LANES perturbations go at once, so that the compiler makes vectors of them. The motion isn't
computed anew but read from the log: a run that doesn't ask for this pays nothing for it.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import FloatArray
from ghostball.engine.sensitivity import state as ts
from ghostball.engine.sensitivity.between_events import (
    add_rounding,
    arrive,
    carry,
    depart,
    shift_before,
)
from ghostball.engine.sensitivity.state import Tangents
from ghostball.engine.sensitivity.through_impacts import pass_cushion, pass_impact, pass_pocket
from ghostball.model.events import EventKind

_BALL_BALL = int(EventKind.BALL_BALL)
_BALL_CUSHION = int(EventKind.BALL_CUSHION)
_POCKETED = int(EventKind.POCKETED)


@kernel(entry=True)
def run_tangent(run: Tangents) -> None:
    """Carry the perturbations at the start of each ball to all its segments.

    Contract: no allocation. Where none of first order exists, `run.tangent` isn't finite from there
    on: where a ball has two collisions at one instant, whose order a perturbation would decide; and
    where a segment comes from sustained contact, whose forces aren't in the log.
    """
    for ball in range(len(run.at)):
        run.at[ball] = run.first[ball]
        if run.rounding > 0.0:
            k = run.first[ball]
            for one in range(ts.ROW_LENGTH):
                run.work[one] = run.tangent[k * ts.ROW_LENGTH + one]
            add_rounding(run, ball, k, 0.0, 0, 0)
            for one in range(ts.ROW_LENGTH):
                run.tangent[k * ts.ROW_LENGTH + one] = run.work[one]
    events = len(run.time)
    e = 0
    while e < events:
        end = e + 1
        while end < events and run.time[end] == run.time[e]:
            end += 1
        _count_due(run, e, end, 1)
        for one in range(e, end):
            _pass_event(run, one)
        _count_due(run, e, end, -1)
        e = end
    for ball in range(len(run.at)):
        for k in range(run.at[ball] + 1, run.first[ball + 1]):
            _give_up(run, k)


@kernel(inline=True)
def _count_due(run: Tangents, e: int, end: int, step: int) -> None:
    """Add `step` to `run.due` for each collision of a ball among events e to end."""
    for one in range(e, end):
        kind = run.what[one, 0]
        if kind == _BALL_BALL:
            run.due[run.what[one, 1]] += step
            run.due[run.what[one, 2]] += step
        elif kind == _BALL_CUSHION:
            run.due[run.what[one, 1]] += step


@kernel(inline=True)
def _pass_event(run: Tangents, e: int) -> None:
    """Take the perturbations of the balls of event e through it, each to its next segment."""
    t, kind, i, j = run.time[e], run.what[e, 0], run.what[e, 1], run.what[e, 2]
    alone = _reach(run, i, t) and run.due[i] < 2
    if kind == _BALL_BALL:
        alone = _reach(run, j, t) and run.due[j] < 2 and alone
    if not alone:
        _give_up_event(run, e)
        return
    arrive(run, i, t, 0)
    if kind == _BALL_BALL:
        arrive(run, j, t, 1)
        pass_impact(run, i, j)
        depart(run, i, t, 0, 2)
        depart(run, j, t, 1, 2)
    else:
        if kind == _BALL_CUSHION:
            pass_cushion(run, i, j)
        elif kind == _POCKETED:
            pass_pocket(run, i, j)
        else:
            _pass_own_end(run, i)
        depart(run, i, t, 0, 1)
    shift = run.shift[e * ts.LANES : (e + 1) * ts.LANES]
    for lane in range(run.lanes):
        shift[lane] = run.work[ts.TAU + lane]


@kernel(inline=True)
def _reach(run: Tangents, ball: int, t: float) -> bool:
    """Bring a ball to its last segment before that of its event at t; whether there is that one."""
    last = run.first[ball + 1] - 1
    while run.at[ball] < last and run.segments[run.at[ball] + 1, st.EPOCH] < t:
        run.at[ball] += 1  # a segment without an event: sustained contact
        _give_up(run, run.at[ball])
    return bool(run.at[ball] < last and run.segments[run.at[ball] + 1, st.EPOCH] == t)


@kernel
def _give_up_event(run: Tangents, e: int) -> None:
    """Leave no perturbation of first order to the balls of event e."""
    t = run.time[e]
    count = 2 if run.what[e, 0] == _BALL_BALL else 1
    for index in range(count):
        ball = run.what[e, 1 + index]
        if _reach(run, ball, t):
            run.at[ball] += 1
        _give_up(run, run.at[ball])
    for lane in range(run.lanes):
        run.shift[e * ts.LANES + lane] = math.nan


@kernel
def _give_up(run: Tangents, k: int) -> None:
    for index in range(ts.ROW_LENGTH):
        run.tangent[k * ts.ROW_LENGTH + index] = math.nan


@kernel(inline=True)
def _pass_own_end(run: Tangents, ball: int) -> None:
    """Take the perturbation of a ball, in the first row, through the end of its slide or its roll.

    Of which the duration is |u| / (3.5 mu_s g), or |v| / (mu_r g): dtau follows from what they were
    at the ball's last segment.
    """
    k = run.at[ball]
    dx, dy, lever, rate = (
        run.segments[k, st.VX],
        run.segments[k, st.VY],
        0.0,
        run.state[ball, st.ROLL_SLOWING],
    )
    if run.segments[k, st.PHASE] == st.SLIDING:
        lever, rate = run.state[ball, st.RADIUS], 3.5 * run.state[ball, st.SLIDE_SLOWING]
        dx, dy = dx - lever * run.segments[k, st.WY], dy + lever * run.segments[k, st.WX]
    over = 1.0 / (rate * math.sqrt(dx * dx + dy * dy))
    start = run.tangent[k * ts.ROW_LENGTH : (k + 1) * ts.ROW_LENGTH]
    for lane in range(run.lanes):
        ux = start[ts.DVX + lane] - lever * start[ts.DWY + lane]
        uy = start[ts.DVY + lane] + lever * start[ts.DWX + lane]
        run.work[ts.TAU + lane] = over * (dx * ux + dy * uy)
    shift_before(run, 0)


@kernel(entry=True)
def sample_tangent(run: Tangents, times: FloatArray, out: FloatArray) -> None:
    """Put in `out`, (k, n, ROW_LENGTH), the perturbations at `times`, (k,) [s], increasing.

    After an event where one falls on a time. Contract: `run_tangent` has run; no time lies beyond
    the motion's end. No allocation.
    """
    row = run.work[ts.FIRST_BALL : ts.FIRST_BALL + ts.ROW_LENGTH]
    for ball in range(len(run.at)):
        k = run.first[ball]
        for m in range(len(times)):
            while k + 1 < run.first[ball + 1] and run.segments[k + 1, st.EPOCH] <= times[m]:
                k += 1
            carry(run, ball, k, times[m], row)
            for index in range(ts.ROW_LENGTH):
                out[m, ball, index] = row[index]


@kernel(entry=True)
def sample_growth(run: Tangents, times: FloatArray, out: FloatArray) -> None:
    """Put in `out`, (k, n), how far the perturbations are, root mean square over lanes [m].

    At `times`, as `sample_tangent`; inf where none of first order exists.
    """
    row = run.work[ts.FIRST_BALL : ts.FIRST_BALL + ts.ROW_LENGTH]
    for ball in range(len(run.at)):
        k = run.first[ball]
        for m in range(len(times)):
            while k + 1 < run.first[ball + 1] and run.segments[k + 1, st.EPOCH] <= times[m]:
                k += 1
            carry(run, ball, k, times[m], row)
            out[m, ball] = _root_mean_square(run.lanes, row)


@kernel
def _root_mean_square(lanes: int, row: FloatArray) -> float:
    """Return the root mean square length of the displacements in a row [m]; inf for a NaN.

    Scaled by the largest, for a square may overflow.
    """
    largest = 0.0
    for lane in range(lanes):
        x, y = abs(row[ts.DX + lane]), abs(row[ts.DY + lane])
        if not math.isfinite(x + y):
            return math.inf
        largest = max(largest, x, y)
    if largest == 0.0:
        return 0.0
    total = 0.0
    for lane in range(lanes):
        x, y = row[ts.DX + lane] / largest, row[ts.DY + lane] / largest
        total += x * x + y * y
    return largest * math.sqrt(total / ts.LANES)
