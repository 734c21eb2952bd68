"""An example engine to start from, or to test the suite with.

    pytest ghostball:: --ghostball-engine ghostball.validation.examples.stepper:Stepper

It detects contacts up to one time step late, and states this in its `resolution`: its results are
judged by limits for a step of this size.
"""

from itertools import combinations
from typing import ClassVar

import numpy as np
from pydantic import Field

from ghostball.model import (
    EventKind,
    Record,
    Result,
    Samples,
    Scene,
    Status,
    rolling_angular_velocity,
)
from ghostball.model.features import EXACT, Capabilities, Feature
from ghostball.reference_adapters import EngineBase, EngineSettings
from ghostball.reference_adapters.base import resolution_of_step
from ghostball.reference_adapters.recording import Recorder


class StepperSettings(EngineSettings):
    """Settings of `stepper:dt=1e-4`."""

    dt: float = Field(default=1e-3, ge=1e-6, le=1e-2, description="time step [s]")


class Stepper(EngineBase):
    """Equal balls that roll on a table in time steps, and bounce if they overlap."""

    name, Settings = "stepper", StepperSettings
    capabilities: ClassVar[Capabilities] = {Feature.ROLLING: EXACT, Feature.MIRROR_CUSHION: EXACT}

    def resolution(self, scene: Scene) -> float:
        """Return the position error at a collision [m]: the path of a ball in one time step."""
        return resolution_of_step(self.settings.dt, scene)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Run the scene; see `ReferenceEngine.simulate`."""
        self.check(scene)
        assert scene.table is not None  # `check` requires cushions
        recorder, t, dt = Recorder(scene, record), 0.0, self.settings.dt
        x, v, radii = scene.positions, scene.velocities, scene.radii
        far = np.array([scene.table.length, scene.table.width, np.inf]) - radii[0]
        slowing = dt * scene.physics.gravity * scene.rolling_frictions  # in a step [m/s]
        while v.any():
            recorder.frame(t, Samples(x[None], v[None], rolling_angular_velocity(v, radii)[None]))
            v = v * (1.0 - slowing / np.maximum(np.linalg.norm(v, axis=1), slowing))[:, None]
            t, x = t + dt, x + dt * v
            leaving = ((x < radii[0]) & (v < 0.0)) | ((x > far) & (v > 0.0))
            v[leaving] *= -1.0
            for ball, axis in np.argwhere(leaving):
                recorder.event(t, EventKind.BALL_CUSHION, ball, 2 * axis + (v[ball, axis] < 0.0))
            for a, b in combinations(range(len(x)), 2):
                distance = np.linalg.norm(x[b] - x[a])
                normal = (x[b] - x[a]) / distance
                approach_speed = (v[a] - v[b]) @ normal
                if approach_speed > 0.0 and distance < radii[a] + radii[b]:
                    v[[a, b]] += approach_speed * np.array([-normal, normal])
                    recorder.event(t, EventKind.BALL_BALL, a, b)
        end = Samples(x[None], v[None], v[None])
        return recorder.result(
            engine=self.name,
            settings=self.settings.model_dump(),
            status=Status.REST,
            final_state=end,
            rest_time=t,
            work={},
        )
