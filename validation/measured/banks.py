r"""Simulated banks: where a sliding ball must be aimed at a cushion to return to a corner.

    through             the opposite line of diamonds
       \       0        the opposite groove; its 0 is the corner
        \     /
         \   /
          \ /           the groove of the cushion: where the ball's centre turns
          aim           the cushion's line of diamonds

Both positions are counted in diamonds from the corner; the line of aim passes through both.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from ghostball.model import Physics, Table
from ghostball.model.arrays import FloatArray
from ghostball.validation.measured.simulated_ball import POOL_BALL, OperatorError, Play, track_of

_DIAMOND: Final = 12.5 * 0.0254  # [m]
_GROOVE_TO_GROOVE: Final = 48.25 * 0.0254  # from groove to groove [m]
_GROOVE_TO_DIAMONDS: Final = 4.25 * 0.0254  # from a groove to its line of diamonds [m]
"""In inches for a table of 9 feet in Alciatore's technical proof TP B.27."""

SPEED: Final = 4.0
"""Speed of a ball that starts without spin [m/s]."""
START_DISTANCE: Final = 0.2
"""Distance from the cushion's groove at the start [m]: the ball still slides when it arrives."""

_PATH: Final = 4.0
"""Path of a ball at its initial speed during the simulation [m]; banks need 2.8 to 3.6."""
_RATE: Final = 500.0  # sampling rate [1/s]
_AIM: Final = 4.0  # coordinate of the aim, from the lower end of the table [m]
_FAR_CUSHION: Final = 0.5  # distance of the other cushion behind its groove [m]
_FIRST_RATIO: Final = 0.8
"""First estimate of the path back, divided by the path there, along the cushion; real tables have
1/1.2.
"""


def through_points(
    play: Play,
    physics: Physics,
    aims: Sequence[float],
    *,
    speed: float = SPEED,
    before: float = START_DISTANCE,
) -> list[float]:
    """Return where each line of aim crosses the opposite line of diamonds [diamonds].

    `aims`: where they cross the line of diamonds of the cushion, increasing [diamonds].
    `speed`: of a ball that starts without spin [m/s], at a distance `before` from the groove [m].

    The ratio of the paths along the cushion, back and there, hardly depends on the angle. The ratio
    for one aim therefore gives the angle for the next, within a hundredth of a diamond.

    Raises `OperatorError` if a ball doesn't come back to the opposite groove.
    """
    found = []
    kept = _kept(play, physics, _slope(aims[0], _FIRST_RATIO), speed, before)
    for aim in aims:
        kept = _kept(play, physics, _slope(aim, kept), speed, before)
        found.append(
            aim + _slope(aim, kept) * (_GROOVE_TO_GROOVE + 2.0 * _GROOVE_TO_DIAMONDS) / _DIAMOND
        )
    return found


def _slope(aim: float, kept: float) -> float:
    """Return the slope of the line of aim that leads to the corner.

    The slope is the distance along the cushion divided by the distance across.
    The ball meets the groove at aim + slope * behind, and comes back by kept * slope * across.
    """
    if kept * _GROOVE_TO_GROOVE <= _GROOVE_TO_DIAMONDS:
        raise OperatorError("a bank comes back so steeply that no line of aim leads to the corner")
    return aim * _DIAMOND / (kept * _GROOVE_TO_GROOVE - _GROOVE_TO_DIAMONDS)


def _kept(play: Play, physics: Physics, slope: float, speed: float, before: float) -> float:
    """Return the path of a ball along the cushion after the bank, divided by that before it."""
    groove = POOL_BALL.radius + _FAR_CUSHION + _GROOVE_TO_GROOVE
    along, across = np.array([-slope, 1.0]) / np.hypot(slope, 1.0)
    track = track_of(
        play,
        physics,
        Table(length=_AIM + 2.0, width=groove + POOL_BALL.radius),
        POOL_BALL,
        position=(_AIM + slope * before, groove - before),
        velocity=(float(speed * along), float(speed * across)),
        angular_velocity=(0.0, 0.0, 0.0),
        lasts=_PATH / speed,
        rate=_RATE,
    )
    crossing = _crossing(track.positions, groove - _GROOVE_TO_GROOVE)
    return (_AIM - crossing) / (slope * _GROOVE_TO_GROOVE)


def _crossing(positions: FloatArray, line: float) -> float:
    """Return where a returning ball crosses a line across y; positions (n, 2) [m]."""
    along, across = positions.T
    beyond = np.flatnonzero(across <= line)
    if not len(beyond):
        raise OperatorError("a bank doesn't come back across the table")
    k = int(beyond[0])
    part = (across[k - 1] - line) / (across[k - 1] - across[k])
    return float(along[k - 1] + part * (along[k] - along[k - 1]))
