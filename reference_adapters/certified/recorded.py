"""The motion of a proved shot for an `ExactTrajectory`: the middles of intervals, as doubles."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate
from typing import NamedTuple

import numpy as np
from flint import arb

from ghostball.model import Phase
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.certified.arithmetic import ZERO, unit
from ghostball.reference_adapters.certified.certificate import segment_columns
from ghostball.reference_adapters.certified.integrated_slide import SlidePiece
from ghostball.reference_adapters.certified.motion import Body
from ghostball.reference_adapters.certified.run import CertifiedRun

POWERS = 20
"""Highest power of the time in the displacement of a ball slowed by air."""

PIECES_IN_REACH = 6.0
"""Radius of convergence of a roll in air divided by the length of a piece.

The truncation error is at most 6^-20 of the displacement, about the rounding of a double. For a
slide it is 4^-20 of the effect of the air in a piece.
"""

_SHORTEST_PIECE = 2.0**-30
"""Shortest piece of a slide [s]: the previous piece continues instead, for a few nanometres."""

Row = tuple[float, ...]


class RecordedMotion(NamedTuple):
    """The motion in a `Certificate`; the fields are documented there."""

    columns: tuple[str, ...]
    segments: tuple[FloatArray, ...]
    starts: tuple[tuple[int, ...], ...]


def recorded(run: CertifiedRun, end: arb) -> RecordedMotion:
    """Return the motion of each ball up to a time.

    It has more powers of the time if air slows a ball.
    """
    counts: list[list[int]] = [[] for _ in run.bodies]
    rows: list[list[Row]] = [[] for _ in run.bodies]
    until = [end] * len(run.bodies)
    curved = any(body.curved for _, body in run.segments)
    columns = segment_columns(POWERS if curved else 2, lifts=run.airborne)
    for k, body in reversed(run.segments):
        lasts = float(until[k] - body.t)
        if body.roll is not None:
            pieces = _in_a_line(body, lasts)
        elif body.slide is not None:
            pieces = _sliding(body, lasts)
        else:
            pieces = [_parabola(body)]
        if run.airborne:
            pieces = [(*row[:14], *_lift(body), *row[14:]) for row in pieces]
        rows[k][:0] = [(*row, *[0.0] * (len(columns) - len(row))) for row in pieces]
        counts[k].insert(0, len(pieces))
        until[k] = body.t
    return RecordedMotion(
        columns,
        tuple(np.array(row, dtype=np.float64) for row in rows),
        tuple(tuple(accumulate(of_ball[:-1], initial=0)) for of_ball in counts),
    )


def _lift(body: Body) -> Row:
    """Return the height of the lowest point, the upward velocity and the downward acceleration."""
    height, up, pull = body.vertical
    return float(height - body.constants.radius), float(up), -float(pull)


def _parabola(body: Body) -> Row:
    slides = body.phase is Phase.SLIDING
    pull = (5 * body.ax / 2, 5 * body.ay / 2) if slides else (ZERO, ZERO)
    q = (body.ux - body.vx, body.uy - body.vy)
    displacement = [(body.x, body.y), (body.vx, body.vy), (body.ax / 2, body.ay / 2)]
    return _row(body, ZERO, displacement, [q, pull])


def _in_a_line(body: Body, lasts: float) -> list[Row]:
    """Return straight motion slowed by air and rolling friction, in pieces, up to a time [s]."""
    assert body.roll is not None
    x, y = unit(body.vx, body.vy, "whether it moves or rests")
    rows: list[Row] = []
    s = ZERO
    while not rows or float(s) < lasts:
        along = body.roll.series(s, POWERS)
        (vx, vy), (ux, uy) = body.velocity_after(s), body.slip_after(s)
        displacement = [body.position_after(s), *((part * x, part * y) for part in along)]
        rows.append(_row(body, s, displacement, [(ux - vx, uy - vy)]))
        s = (s + body.roll.reach(s) / PIECES_IN_REACH).mid()
    return rows


def _sliding(body: Body, lasts: float) -> list[Row]:
    """Return a slide in air in pieces, up to a time [s]."""
    assert body.slide is not None
    rows: list[Row] = []
    for piece in body.slide.pieces:
        t = piece.start
        if float(body.slide.duration - t) < _SHORTEST_PIECE or (rows and float(t) >= lasts):
            break
        rows.append(_slid(body, piece))
    return rows or [_parabola(body)]


def _slid(body: Body, piece: SlidePiece) -> Row:
    spin = (piece.slip[0] - piece.velocity[0], piece.slip[1] - piece.velocity[1])
    displacement = [(piece.displacement[0][n], piece.displacement[1][n]) for n in range(POWERS + 1)]
    displacement[0] = (body.x + displacement[0][0], body.y + displacement[0][1])
    return _row(body, piece.start, displacement, [(spin[0][n], spin[1][n]) for n in range(POWERS)])


def _row(
    body: Body, s: arb, displacement: Sequence[tuple[arb, arb]], q: Sequence[tuple[arb, arb]]
) -> Row:
    """Return a segment that starts a time s after the body's start time.

    `displacement`: (x, y) by power of the time since then.
    `q`: u - v, from u = (vx - R wy, vy + R wx).
    """
    radius = body.constants.radius
    turns = [(float(y / radius), float(-x / radius)) for x, y in q]
    turns += [(0.0, 0.0)] * (POWERS - len(turns))
    place, v, a = ((float(x), float(y)) for x, y in displacement[:3])
    spin = float(body.spin_after(s))
    row = [float(body.t + s), *place, *v, 2.0 * a[0], 2.0 * a[1], *turns[0], spin]
    row += [*turns[1], 0.0, float(body.phase)]
    if len(displacement) > 3:
        further = [(ZERO, ZERO), *displacement[3:]]
        for (x, y), turn in zip(further, [*turns[2:], (0.0, 0.0)], strict=True):
            row += [float(x), float(y), 0.0, *turn]
    return tuple(row)
