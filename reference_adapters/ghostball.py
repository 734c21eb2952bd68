"""Ghostball's engine, with the same interface as the external engines."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field, field_validator

from ghostball.engine import simulate
from ghostball.engine.capabilities import CAPABILITIES
from ghostball.engine.core.tolerances import slide_resolution
from ghostball.engine.running.skips import chosen_skips
from ghostball.engine.shot import MAX_EVENTS, MAX_WORK
from ghostball.model import Record, Result, Scene
from ghostball.model.features import Capabilities
from ghostball.reference_adapters.base import EngineBase, EngineSettings, resolution_of_step


class GhostballSettings(EngineSettings):
    """Settings of Ghostball's engine, which has no time step and no tolerances to choose."""

    max_events: Annotated[int, Field(gt=0)] = MAX_EVENTS
    """Number of events after which a run stops with `Status.EVENT_LIMIT`."""
    max_work: Annotated[int, Field(gt=0)] = MAX_WORK
    """Number of loop iterations (6 ns each) after which a run stops with `Status.WORK_LIMIT`."""
    no_skip: str | None = None
    """Names of skips to disable, joined by "+"; they are listed in `engine.running.skips`."""

    @field_validator("no_skip")
    @classmethod
    def _names_skips(cls, value: str | None) -> str | None:
        """Reject unknown names of skips, and sort the names."""
        return "+".join(sorted(chosen_skips(_names(value)))) or None


class GhostballEngine(EngineBase):
    """Continuous collision detection in closed form; see the package `engine`."""

    name: ClassVar[str] = "ghostball"
    Settings: ClassVar[type[EngineSettings]] = GhostballSettings

    @property
    def capabilities(self) -> Capabilities:
        """How each feature of a scene is supported; the same for all settings."""
        return CAPABILITIES

    def resolution(self, scene: Scene) -> float:
        """Return 0, because only rounding causes errors, or the error of slides in air [m]."""
        physics = scene.physics
        sliding = physics.gravity * scene.sliding_frictions[scene.sliding_frictions > 0.0]
        if physics.motion != "sliding" or physics.air_drag == 0.0 or not len(sliding):
            return 0.0
        slowing = physics.gravity * float(np.min(scene.rolling_frictions))
        fastest = resolution_of_step(1.0, scene)
        # The slip of a ball is at most its speed plus R w; friction ends it at 7/2 of its own rate.
        surface = scene.radii * np.linalg.norm(scene.angular_velocities, axis=1)
        slip = np.max(np.linalg.norm(scene.velocities, axis=1) + surface)
        slid = math.sqrt(2.0) * fastest * float(slip / (3.5 * np.min(sliding)))
        place = float(np.max(np.abs(scene.positions[:, :2]).sum(axis=1) + scene.radii)) + slid
        drag, most = physics.air_drag, float(np.max(sliding))
        return slide_resolution(fastest, slowing, most, drag, place, scene.t_max)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Simulate the scene; see `engine.simulate`."""
        settings = self.settings
        return simulate(
            scene,
            record=record,
            max_events=settings.max_events,
            max_work=settings.max_work,
            no_skip=_names(settings.no_skip),
        )


def _names(joined: str | None) -> list[str]:
    return joined.split("+") if joined else []
