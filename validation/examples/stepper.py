"""An engine to begin from, and to see the suite judge before there is one of your own.

    pytest ghostball:: --ghostball-engine ghostball.validation.examples.stepper:Stepper

It sees contacts up to a step late, and says so by its `resolution`: its shots are held to what a
step of that size allows.
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
    """What `stepper:dt=1e-4` sets."""

    dt: float = Field(default=1e-3, ge=1e-6, le=1e-2, description="time step [s]")


class Stepper(EngineBase):
    """Equal balls that roll on a table in steps, and bounce where they overlap."""

    name, Settings = "stepper", StepperSettings
    capabilities: ClassVar[Capabilities] = {Feature.ROLLING: EXACT, Feature.MIRROR_CUSHION: EXACT}

    def resolution(self, scene: Scene) -> float:
        """Return how far off a ball may be when it collides [m]: what it goes in a step."""
        return resolution_of_step(self.settings.dt, scene)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Run the scene; see `ReferenceEngine.simulate`."""
        self.check(scene)
        assert scene.table is not None  # seen to by the check: it asks for cushions
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
