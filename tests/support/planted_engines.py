"""Engines with one planted cause of error each, which a diagnosis must name."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from toy_engines import NoSettings

from ghostball.engine import simulate
from ghostball.model import (
    Ball,
    EventKind,
    Physics,
    SampledTrajectory,
    Samples,
    Scene,
    Table,
)
from ghostball.model.features import EXACT, Feature
from ghostball.reference_adapters import EngineBase, EngineSettings
from ghostball.reference_adapters.function import engine_of, plays

PLAYED = (
    *(Feature.ROLLING, Feature.FRICTIONLESS_CLOTH, Feature.BALL_RESTITUTION),
    *(Feature.MIRROR_CUSHION, Feature.UNBOUNDED_CLOTH),
)


@dataclass(frozen=True)
class Planted:
    """The planted errors of a time-stepping engine.

    `energy`, `cushion_energy`: factors on the energy of the balls at a collision.
    `rolling`: factor on the rolling friction.
    `restitution`: function of the scene's restitution.
    `turned` [rad]: rotation of the normal of a collision.
    `rest`: function of the rest positions.
    `times`: factor on all times.
    `events_late` [s]: delay of the events.
    """

    energy: float = 1.0
    cushion_energy: float = 1.0
    rolling: float = 1.0
    restitution: Callable[[float], float] = lambda e: e
    turned: float = 0.0
    rest: Callable[[np.ndarray], np.ndarray] = lambda x: x
    times: float = 1.0
    events_late: float = 0.0


def stepping(planted=None, dt=1e-3, **wrong):
    """Return a time-stepping engine for rolling balls, like the example of `ghostball init`."""
    one = planted or Planted(**wrong)

    @plays(*PLAYED)
    def run(scene, dt=dt):
        return _steps(scene, dt, one)

    return engine_of(run, "planted:planted")()


def _steps(scene, dt, planted):
    physics, table, end = scene.physics, scene.table, scene.t_max or np.inf
    t, x, v, radius = 0.0, scene.positions[:, :2], scene.velocities[:, :2], scene.radii[0]
    near = radius if table else -np.inf
    far = np.array([table.length, table.width]) - radius if table else np.inf
    first, second = np.triu_indices(len(x), k=1)
    e = planted.restitution(physics.ball_restitution)
    c, s = math.cos(planted.turned), math.sin(planted.turned)
    turn = np.array([[c, -s], [s, c]])
    events, samples = [], [(t, x, v)]
    while v.any() and t < end:
        step = min(dt, end - t)
        slowing = step * physics.gravity * physics.rolling_friction * planted.rolling
        speed = np.linalg.norm(v, axis=1, keepdims=True)
        v = v * np.maximum(1.0 - slowing / np.maximum(speed, 1e-9), 0.0)
        x, t = x + step * v, t + step
        leaving = ((x < near) & (v < 0.0)) | ((x > far) & (v > 0.0))
        v[leaving] *= -1.0
        v[leaving.any(axis=1)] *= math.sqrt(planted.cushion_energy)
        for ball, axis in np.argwhere(leaving):
            events.append((t, "ball-cushion", ball, 2 * axis + (v[ball, axis] < 0.0)))
        distances = np.linalg.norm(x[second] - x[first], axis=1)
        for pair in np.flatnonzero(distances < 2.0 * radius):
            a, b = first[pair], second[pair]
            normal = (x[b] - x[a]) / distances[pair]
            approach_speed = (v[a] - v[b]) @ normal
            if approach_speed > 0.0:
                impulse = 0.5 * (1.0 + e) * approach_speed * (turn @ normal)
                v[[a, b]] += np.array([-impulse, impulse])
                v[[a, b]] *= math.sqrt(planted.energy)
                events.append((t, "ball-ball", a, b))
        samples.append((t, x, v))
    k = planted.times
    return {
        "rest_positions": planted.rest(x),
        "events": [(k * at + planted.events_late, *what) for at, *what in events],
        "samples": [(k * at, places, velocities) for at, places, velocities in samples],
    }


class OtherPhysicsEngine(EngineBase):
    """Ghostball's engine with changed physics."""

    name: ClassVar[str] = "other-physics"
    Settings: ClassVar[type[EngineSettings]] = NoSettings
    physics: ClassVar[dict[str, object]] = {}

    @property
    def capabilities(self):
        return dict.fromkeys(Feature, EXACT)

    def simulate(self, scene, *, record="rest"):
        self.check(scene)
        physics = scene.physics.model_copy(update=self.physics)
        played = simulate(scene.model_copy(update={"physics": physics}), record=record)
        return replace(played, engine=self.name, settings={}, scene=scene)


def other_physics(**physics):
    """Return Ghostball's engine with these fields of the physics changed."""
    return type("Other", (OtherPhysicsEngine,), {"physics": physics})()


def hit(angle=0.4, restitution=1.0):
    """Return a short shot: a ball hits another ball, and both soon rest."""
    along = 2.0 * 0.028575 * np.array([math.cos(angle), math.sin(angle)])
    cue = np.array([0.6, 0.6])
    balls = [
        Ball(id="cue", position=tuple(cue), velocity=(1.0, 0.0)),
        Ball(id="object", position=tuple(cue + np.array([0.1, 0.0]) + along)),
    ]
    physics = Physics(preset="paper", rolling_friction=0.1, ball_restitution=restitution)
    return Scene(name="hit", physics=physics, table=Table(length=2.54, width=1.27), balls=balls)


class _TurnedOverEngine(OtherPhysicsEngine):
    """Ghostball's engine; it simulates the mirror image of a shot and mirrors the result back."""

    def simulate(self, scene, *, record="rest"):
        flip = np.array([1.0, -1.0, 1.0])
        start = np.array([0.0, scene.table.width, 0.0])
        balls = [
            Ball(id=one.id, position=tuple(start + flip * p)[:2], velocity=tuple(flip * v)[:2])
            for one, p, v in zip(scene.balls, scene.positions, scene.velocities, strict=True)
        ]
        mirrored = simulate(scene.model_copy(update={"balls": tuple(balls)}), record="trajectory")
        times = np.linspace(0.0, mirrored.rest_time, 2001)
        places, velocities, spins = mirrored.sample(times)
        frames = SampledTrajectory(times, start + flip * places, flip * velocities, -flip * spins)
        events = mirrored.events.copy()
        cushions = events["kind"] == EventKind.BALL_CUSHION
        bottom_or_top = cushions & np.isin(events["b"], (2, 3))
        events["b"][bottom_or_top] = 5 - events["b"][bottom_or_top]
        return replace(
            mirrored,
            engine=self.name,
            settings={},
            scene=scene,
            events=None if record == "rest" else events,
            trajectory=frames if record == "trajectory" else None,
            final_state=Samples(*(part[-1:] for part in frames.sample(times[-1:]))),
        )


def turned_over():
    """Return Ghostball's engine that simulates the mirror image of a shot."""
    return _TurnedOverEngine()
