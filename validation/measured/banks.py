r"""Slid banks, played: from where a ball is to be aimed at a cushion to come back to a corner.

    through             the opposite line of diamonds
       \       0        the opposite groove; its 0 is the corner
        \     /
         \   /
          \ /           the groove of the cushion: where the ball's centre turns
          aim           the cushion's line of diamonds

Both places are counted in diamonds from the corner; the line of aim goes straight through both.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from ghostball.model import Physics, Table
from ghostball.model.arrays import FloatArray
from ghostball.validation.measured.play import POOL_BALL, OperatorError, Play, track_of

_DIAMOND: Final = 12.5 * 0.0254  # [m]
_ACROSS: Final = 48.25 * 0.0254  # from groove to groove [m]
_BEHIND: Final = 4.25 * 0.0254  # from a groove to its line of diamonds [m]
"""Alciatore's technical proof TP B.27 has them in inches, of a table of 9 feet."""

SPEED: Final = 4.0
"""Of a ball that begins without spin [m/s]."""
BEFORE: Final = 0.2
"""How far from the cushion's groove it begins [m]: it still slides when it comes there."""

_WAY: Final = 4.0
"""What a ball would go meanwhile at its first speed [m]; banks need 2.8 to 3.6."""
_RATE: Final = 500.0  # of samples [1/s]
_FAR: Final = 4.0  # from the lower end of the table, where it is aimed at [m]
_BEYOND: Final = 0.5  # how far the other cushion is behind its groove [m]
_FIRST: Final = 0.8
"""What the way back is of the way there, along the cushion; 1 : 1.2 is about what tables have."""


def through_points(
    play: Play,
    physics: Physics,
    aims: Sequence[float],
    *,
    speed: float = SPEED,
    before: float = BEFORE,
) -> list[float]:
    """Return where each line of aim crosses the opposite line of diamonds [diamonds].

    `aims`: where they cross the cushion's, rising [diamonds]; `speed`: of a ball that begins
    without spin [m/s], `before` the cushion's groove [m].

    How far a ball comes back along the cushion, over how far it came, hardly depends on the angle:
    so what it is of one aim leads to the angle of the next, to a hundredth of a diamond.

    Raises `OperatorError` where a ball doesn't come back to the opposite groove.
    """
    found = []
    kept = _kept(play, physics, _slope(aims[0], _FIRST), speed, before)
    for aim in aims:
        kept = _kept(play, physics, _slope(aim, kept), speed, before)
        found.append(aim + _slope(aim, kept) * (_ACROSS + 2.0 * _BEHIND) / _DIAMOND)
    return found


def _slope(aim: float, kept: float) -> float:
    """Return the slope of the line of aim, along the cushion over across, back into the corner.

    The ball meets the groove at aim + slope * behind, and comes back by kept * slope * across.
    """
    if kept * _ACROSS <= _BEHIND:
        raise OperatorError("a bank comes back so steeply that no line of aim leads to the corner")
    return aim * _DIAMOND / (kept * _ACROSS - _BEHIND)


def _kept(play: Play, physics: Physics, slope: float, speed: float, before: float) -> float:
    """Return how far along the cushion a ball comes back, over how far it came."""
    groove = POOL_BALL.radius + _BEYOND + _ACROSS
    along, across = np.array([-slope, 1.0]) / np.hypot(slope, 1.0)
    track = track_of(
        play,
        physics,
        Table(length=_FAR + 2.0, width=groove + POOL_BALL.radius),
        POOL_BALL,
        position=(_FAR + slope * before, groove - before),
        velocity=(float(speed * along), float(speed * across)),
        angular_velocity=(0.0, 0.0, 0.0),
        lasts=_WAY / speed,
        rate=_RATE,
    )
    crossing = _crossing(track.positions, groove - _ACROSS)
    return (_FAR - crossing) / (slope * _ACROSS)


def _crossing(positions: FloatArray, line: float) -> float:
    """Return where a ball that comes back crosses a line across y; positions (n, 2) [m]."""
    along, across = positions.T
    beyond = np.flatnonzero(across <= line)
    if not len(beyond):
        raise OperatorError("a bank doesn't come back across the table")
    k = int(beyond[0])
    part = (across[k - 1] - line) / (across[k - 1] - across[k])
    return float(along[k - 1] + part * (along[k] - along[k - 1]))
