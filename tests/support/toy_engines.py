"""Engines with known errors: results of Ghostball's engine, displaced by planted errors."""

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ghostball.engine import simulate
from ghostball.model import Ball, Result, Scene
from ghostball.model.features import EXACT, Feature
from ghostball.reference_adapters import EngineBase, EngineSettings
from ghostball.validation.runs.rolling import rolling_spin


def roll(**changes) -> Scene:
    """Return one ball that rolls to rest on an unbounded cloth."""
    cue = Ball(id="cue", position=(0.5, 0.25), velocity=(1.0, 0.5))
    return Scene(**{"name": "roll", "balls": [cue], **changes})


def cut(**changes) -> Scene:
    """Return a half-ball cut on an unbounded cloth."""
    balls = [
        Ball(id="cue", position=(0.5, 0.6), velocity=(1.0, 0.0)),
        Ball(id="object", position=(1.0, 0.628)),
    ]
    return Scene(**{"name": "cut", "balls": balls, **changes})


class ToySettings(EngineSettings):
    """The time step `dt`, and the planted errors."""

    dt: float = 0.01
    model: float = 0.0
    """Displacement of every ball along x [m], independent of the step."""
    slope: float = 0.0
    """Displacement of every ball along y: slope dt^order [m]."""
    order: float = 1.0
    sawtooth: float = 0.0
    """Displacement along y over the remainder of the step at 0.1 s [m/s]."""
    wobble: float = 0.0
    """Displacement of every ball along y [m]; its sign changes with each halving of the step."""


@dataclass(frozen=True)
class _Moved:
    """A motion in which all balls drift by `shift` (3,) [m] from the start to the end."""

    motion: object
    shift: np.ndarray

    @property
    def t_end(self):
        return self.motion.t_end

    def sample(self, times):
        state = self.motion.sample(times)
        part = np.clip(times / self.t_end, 0.0, 1.0)
        return state._replace(
            positions=state.positions + part[:, np.newaxis, np.newaxis] * self.shift
        )


class ToyEngine(EngineBase):
    """Ghostball's engine with planted errors."""

    name: ClassVar[str] = "toy"
    Settings: ClassVar[type[EngineSettings]] = ToySettings

    @property
    def capabilities(self):
        return dict.fromkeys(Feature, EXACT)

    def resolution(self, scene):
        return 0.0

    def simulate(self, scene, *, record="rest"):
        self.check(scene)
        s = self.settings
        # The time since the scene's own start, from the speed, for a shot that starts earlier.
        lead = (scene.balls[0].speed - np.hypot(1.0, 0.5)) / (0.02 * 9.81) if s.sawtooth else 0.0
        late = s.dt - (0.1 + lead) % s.dt
        shift = np.array([s.model, s.slope * s.dt**s.order + s.sawtooth * late, 0.0])
        shift[1] += s.wobble * (-1) ** round(np.log2(0.01 / s.dt))
        result = simulate(scene, record=record)
        return replace(drifted(result, shift), engine=self.name, settings={"dt": s.dt})


def drifted(result: Result, shift: np.ndarray) -> Result:
    """Return a run in which all balls drift by `shift` (3,) [m] until the end of their motion."""
    state, motion = result.final_state, result.trajectory
    return replace(
        result,
        final_state=state._replace(positions=state.positions + shift),
        trajectory=None if motion is None else _Moved(motion, shift),
    )


def changed_shot(scene: Scene, ball: int, speed: float, turn: float) -> Scene:
    """Return the scene with a ball's velocity and spin scaled and rotated.

    `speed` [1]: relative change; the factor is 1 + `speed`.
    `turn` [rad]: angle of rotation about the vertical, to the left.
    """
    one = scene.balls[ball]
    factor, c, s = 1.0 + speed, math.cos(turn), math.sin(turn)
    rotation = factor * np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    v = rotation @ np.array(one.velocity)
    v[2] = one.velocity[2]
    changes: dict[str, object] = {"velocity": tuple(v.tolist())}
    if one.angular_velocity is not None:
        w = tuple((rotation @ np.array(one.angular_velocity)).tolist())
        changes["angular_velocity"] = (
            rolling_spin(v.tolist(), one.radius, w[2]) if scene.rolls[ball] else w
        )
    balls = list(scene.balls)
    balls[ball] = Ball(**{**dict(one), **changes})
    return Scene(**{**dict(scene), "balls": balls})


class NoSettings(EngineSettings):
    """No settings, in particular no time step."""


@dataclass(frozen=True)
class StrokeChange:
    """A relative change of the cue ball's speed, and a change of its direction [rad]."""

    speed: float = 0.0
    turn: float = 0.0


class OtherShotEngine(EngineBase):
    """Ghostball's engine, which simulates the shot with a changed stroke."""

    name: ClassVar[str] = "other-shot"
    Settings: ClassVar[type[EngineSettings]] = NoSettings
    stroke = StrokeChange()

    @property
    def capabilities(self):
        return dict.fromkeys(Feature, EXACT)

    def simulate(self, scene, *, record="rest"):
        self.check(scene)
        played = changed_shot(scene, 0, self.stroke.speed, self.stroke.turn)
        result = simulate(played, record=record)
        return replace(result, engine=self.name, settings={}, scene=scene)


def other_shot(speed: float = 0.0, turn: float = 0.0) -> OtherShotEngine:
    """Return an engine that simulates shots with a changed stroke."""
    engine = OtherShotEngine()
    engine.stroke = StrokeChange(speed, turn)
    return engine
