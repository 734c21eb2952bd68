"""Simulate events on an engine, several in one scene if the engine permits."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ghostball.model import Ball, ExactTrajectory, Physics, Result, Scene, Table
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters import ReferenceEngine
from ghostball.reference_adapters.base import resolution_of
from ghostball.validation.measured.fit.events import SIZE, FitEvent
from ghostball.validation.measured.simulated_ball import Play

Progress = Callable[[int, int, str], None]
"""Called with the number of finished steps, the number of all steps, and the present step."""

_DIGITS = 9
"""Decimal digits of times [s]: times of several events are mostly equal, except for rounding."""

StartedEvent = tuple[FitEvent, FloatArray]
"""An event, and its initial values."""


def scene_of(physics: Physics, played: Sequence[StartedEvent]) -> Scene:
    """Return a scene with several events, each in its own part of the table."""
    balls = [
        Ball(
            id=f"{lane}{ball.id}",
            position=(ball.position[0], ball.position[1] + lane * SIZE),
            velocity=ball.velocity,
            angular_velocity=ball.angular_velocity,
            radius=ball.radius,
        )
        for lane, (event, given) in enumerate(played)
        for ball in event.balls(physics, given)
    ]
    return Scene(
        name="events",
        table=Table(length=SIZE, width=SIZE * len(played)),
        physics=physics,
        balls=balls,
        t_max=max(float(event.times[-1]) for event, _ in played) + 0.01,
    )


def seen_in(result: Result, played: Sequence[StartedEvent]) -> list[FloatArray]:
    """Return the seen values of each event in the motion of their `scene_of`."""
    times = [np.round(event.times, _DIGITS) for event, _ in played for _ in range(event.count)]
    places = iter(_places(result, times))
    seen = []
    for lane, (event, _) in enumerate(played):
        own = np.stack([next(places) for _ in range(event.count)], axis=1)
        seen.append(event.read(own - (0.0, lane * SIZE)))
    return seen


def _places(result: Result, times: Sequence[FloatArray]) -> list[FloatArray]:
    """Return the positions (k_i, 2) of each ball at its own times (k_i,)."""
    if isinstance(result.trajectory, ExactTrajectory):
        # All balls at the times of all events take several times as long as the simulation.
        return [own[:, :2] for own in result.trajectory.positions_apart(times)]
    every = np.unique(np.concatenate(times))
    positions = result.sample(every).positions[..., :2]
    return [positions[np.searchsorted(every, own), ball] for ball, own in enumerate(times)]


class EventSimulator:
    """An engine that simulates events and reports its progress."""

    def __init__(self, engine: ReferenceEngine, play: Play, progress: Progress | None) -> None:
        self._engine, self._play, self._progress = engine, play, progress
        self._played, self._step, self._done = 0, "", -1
        self.steps = 1

    def begin(self, step: str) -> None:
        """Start the next one of `steps`."""
        self._step, self._done = step, self._done + 1

    def predict(self, physics: Physics, played: Sequence[StartedEvent]) -> list[FloatArray]:
        """Return the simulated `seen` values of each event.

        An engine with rounding errors only simulates many events in one scene, in a sixth of the
        time. For other engines, a large table or many balls may change the results.
        """
        seen: list[FloatArray] = []
        at_once = 1
        while len(seen) < len(played):
            part = played[len(seen) : len(seen) + at_once]
            scene = scene_of(physics, part)
            seen += seen_in(self._play(scene), part)
            if resolution_of(self._engine, scene) == 0.0:
                at_once = _MOST_TOGETHER
            self._tell(len(part))
        return seen

    def _tell(self, played: int) -> None:
        """Report the progress."""
        before, self._played = self._played, self._played + played
        if (
            self._progress is not None
            and before // _REPORT_INTERVAL < self._played // _REPORT_INTERVAL
        ):
            self._progress(self._done, self.steps, f"{self._step}, {self._played} shots simulated")


_MOST_TOGETHER = 16
"""Largest number of events in one scene."""
_REPORT_INTERVAL = 100
"""Number of shots between progress reports."""
