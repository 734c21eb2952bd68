"""What engines make of measured cloth: how it slows balls that roll."""

from __future__ import annotations

from typing import Final

from ghostball.model import Ball, Physics, Scene, Table
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.measured.best import best_cloth, best_cushion
from ghostball.validation.measured.facts import facts_of
from ghostball.validation.measured.family import Family, Measured, family_of
from ghostball.validation.measured.play import OperatorError, Play, rolling_deceleration
from ghostball.validation.measured.rolling import RollingWindows, rolling_windows
from ghostball.validation.measured.tracks import Surface, tracks_of

_WINDOWS: Final = RollingWindows(slowest=0.0)
_LONG: Final = 10.0  # table [m]
_PLAYED: Final = 1.65  # [s]


def pool_rolling(engine: ReferenceEngine, play: Play) -> Family:
    """Return how the cloth of nine-ball matches slowed cue balls."""
    facts = facts_of("rolling-pool")
    cloth = best_cloth("rolling-pool", engine.capabilities)
    cushion = best_cushion("cushion-carom", engine.name, engine.capabilities) or {}

    def figures() -> tuple[Measured, ...]:
        physics = Physics(motion="sliding", **cloth, **cushion)
        return tuple(Measured.of(row, deceleration(play, physics, row.place)) for row in facts.rows)

    return family_of(facts, "rolling-pool", "rolling").played(cloth, figures)


def deceleration(play: Play, physics: Physics, speed: float) -> float:
    """Return how a model slows a rolling ball that has a speed in the middle of a window [m/s^2].

    Raises `OperatorError` where it doesn't roll.
    """
    slowing = rolling_deceleration(physics, speed)
    start = speed + slowing * (_WINDOWS.after + _WINDOWS.length / 2.0)
    ball = Ball(id="cue", position=(1.0, 1.0), velocity=(start, 0.0))
    table = Table(length=_LONG, width=2.0)
    scene = Scene(name="rolls", table=table, physics=physics, balls=[ball], t_max=_PLAYED)
    found = rolling_windows(
        tracks_of(play(scene)), Surface(table.length, table.width, ball.radius), _WINDOWS
    )
    if not found:
        raise OperatorError(f"a ball that begins to roll at {start:.3g} m/s doesn't roll")
    return found[0].deceleration
