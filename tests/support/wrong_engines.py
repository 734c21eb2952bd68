"""An engine that is wrong in ten ways, each of which every command has to see."""

from __future__ import annotations

import os
import random
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import simulate
from ghostball.model import Record, Result, SampledTrajectory, Scene
from ghostball.model.features import EXACT, Capabilities, Feature
from ghostball.reference_adapters import EngineBase, EngineSettings


class WrongSettings(EngineSettings):
    """What is wrong with it: one of `WAYS`, or nothing."""

    way: str = "right"


class Wrong(EngineBase):
    """Our engine, which claims to err by rounding alone, with a bug; its motion is in frames."""

    name: ClassVar[str] = "wrong"
    Settings: ClassVar[type[EngineSettings]] = WrongSettings
    capabilities: ClassVar[Capabilities] = dict.fromkeys(Feature, EXACT)

    def resolution(self, scene: Scene) -> float:
        """Claim that balls are off by rounding alone when they collide."""
        return 0.0

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Simulate, wrongly."""
        self.check(scene)
        way = self.settings.way
        result = WAYS[way](scene) if way in WAYS else framed(simulate(scene, record="trajectory"))
        events, motion = result.events, result.trajectory
        return replace(
            result,
            engine=self.name,
            settings={},
            scene=scene,
            events=None if record == "rest" else events,
            trajectory=motion if record == "trajectory" else None,
        )


def framed(result: Result) -> Result:
    """Return a run with its motion in frames, some just before and at each event."""
    assert result.events is not None
    at = result.events["t"]
    grid = np.linspace(0.0, result.rest_time, 501)
    times = np.unique(np.concatenate([grid, at, np.maximum(np.nextafter(at, 0.0), 0.0)]))
    return replace(result, trajectory=SampledTrajectory(times, *result.sample(times)))


def _with_physics(**change: Callable[[float], float]) -> Callable[[Scene], Result]:
    def play(scene: Scene) -> Result:
        update = {name: law(getattr(scene.physics, name)) for name, law in change.items()}
        physics = scene.physics.model_copy(update=update)
        other = scene.model_copy(update={"physics": physics})
        return framed(simulate(other, record="trajectory"))

    return play


def _makes_energy(scene: Scene) -> Result:
    """Give the balls 5 % of energy more at their first collision."""
    whole = simulate(scene, record="trajectory")
    assert whole.events is not None
    collision = float(whole.events["t"][whole.events["kind"] < 2][0])
    before, after = framed(whole), whole.sample([collision])
    balls = tuple(
        ball.model_copy(update={"position": tuple(x), "velocity": tuple(1.05**0.5 * v)})
        for ball, x, v in zip(
            scene.balls, after.positions[0].tolist(), after.velocities[0], strict=True
        )
    )
    rest = framed(simulate(scene.model_copy(update={"balls": balls}), record="trajectory"))
    first, second = before.trajectory, rest.trajectory
    assert isinstance(first, SampledTrajectory)
    assert isinstance(second, SampledTrajectory)
    early = first.times < collision
    assert rest.events is not None
    later = rest.events.copy()
    later["t"] += collision
    parts = (
        np.concatenate([getattr(first, name)[early], getattr(second, name)])
        for name in ("positions", "velocities", "angular_velocities")
    )
    times = np.concatenate([first.times[early], collision + second.times])
    return replace(
        rest,
        events=np.concatenate([whole.events[whole.events["t"] <= collision], later]),
        collision_counts=whole.collision_counts,
        rest_time=rest.rest_time + collision,
        trajectory=SampledTrajectory(times, *parts),
    )


def _overlaps(scene: Scene) -> Result:
    """Put a ball 5 mm into another one for a moment."""
    result = framed(simulate(scene, record="trajectory"))
    motion = result.trajectory
    assert isinstance(motion, SampledTrajectory)
    positions = motion.positions.copy()
    first, second = positions[:, 0], positions[:, 1]
    k = int(np.argmin(np.linalg.norm(second - first, axis=1)))
    positions[k, 1] = first[k] + 0.9 * (second[k] - first[k])
    return replace(result, trajectory=replace(motion, positions=positions))


def _misses(scene: Scene) -> Result:
    """Let the balls pass through each other: they are played 50 m apart."""
    away = np.array([0.0, 50.0, 0.0])
    offsets = np.arange(len(scene.balls))[:, np.newaxis] * away
    return _moved(scene.model_copy(update={"table": None}), offsets)


def _late(scene: Scene) -> Result:
    """See a collision when the balls are half a millimetre into each other."""
    less = 0.25e-3
    shorter = np.full((len(scene.balls), 1), -less) * np.array([0.0, 0.0, 1.0])
    return _moved(scene, shorter, radius=lambda radius: radius - less)


def _moved(scene: Scene, by: NDArray[np.float64], **change: Callable[[float], float]) -> Result:
    """Play a scene whose balls lie elsewhere, (n, 3) [m], and move what comes of it back."""
    places = scene.positions + by
    balls = tuple(
        ball.model_copy(
            update={"position": tuple(place)}
            | {name: law(getattr(ball, name)) for name, law in change.items()}
        )
        for ball, place in zip(scene.balls, places.tolist(), strict=True)
    )
    result = framed(simulate(scene.model_copy(update={"balls": balls}), record="trajectory"))
    motion, end = result.trajectory, result.final_state
    assert isinstance(motion, SampledTrajectory)
    return replace(
        result,
        trajectory=replace(motion, positions=motion.positions - by),
        final_state=end._replace(positions=end.positions - by),
    )


def _not_finite(scene: Scene) -> Result:
    result = framed(simulate(scene, record="trajectory"))
    motion = result.trajectory
    assert isinstance(motion, SampledTrajectory)
    velocities = motion.velocities.copy()
    velocities[len(velocities) // 2, 0, 0] = np.nan
    return replace(result, trajectory=replace(motion, velocities=velocities))


def _nondeterministic(scene: Scene) -> Result:
    """Play with another stroke each time, by up to a thousandth."""
    more = 1.0 + 1e-3 * random.SystemRandom().uniform(0.1, 1.0)
    balls = tuple(
        ball.model_copy(update={"velocity": tuple(more * part for part in ball.velocity)})
        for ball in scene.balls
    )
    return framed(simulate(scene.model_copy(update={"balls": balls}), record="trajectory"))


def _crashes(scene: Scene) -> Result:
    os._exit(7)


def _hangs(scene: Scene) -> Result:
    while True:
        time.sleep(1.0)


WAYS: Mapping[str, Callable[[Scene], Result]] = {
    "energy": _makes_energy,
    "overlap": _overlaps,
    "missed-collision": _misses,
    "late-collision": _late,
    "friction": _with_physics(rolling_friction=lambda friction: 1.05 * friction),
    "restitution": _with_physics(ball_restitution=lambda e: min(e, 0.9) ** 2),
    "not-finite": _not_finite,
    "nondeterministic": _nondeterministic,
    "crash": _crashes,
    "hang": _hangs,
}
"""How it is wrong."""
