"""Pymunk (Chipmunk): a 2D engine with fixed time steps (top view of the table).

A contact is detected when balls overlap at the end of a time step, so up to one step late. By then
the balls have passed the contact point, which makes cuts too thin. `contact_steps="fixed"` is this
standard behaviour. With `contact_steps="exact"`, time steps end exactly at contacts, so only the
error of the solver remains. `config="tuned"` uses the best settings found in experiments,
`config="naive"` the settings that a newcomer types.
"""

from __future__ import annotations

import importlib.util
from typing import Any, ClassVar

from ghostball.model import Scene
from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.stepping.joints import JointStepper
from ghostball.reference_adapters.stepping.plane import WorldStepper
from ghostball.reference_adapters.stepping.plane_engine import PlaneEngine
from ghostball.reference_adapters.stepping.run_end import end_of
from ghostball.reference_adapters.stepping.settings import OwnClothSettings


class PymunkSettings(OwnClothSettings):
    """Settings of the Pymunk adapter.

    `cloth`: Pymunk's joints slow balls that only roll. With "closed-form", the adapter also shifts
        the velocities by half a time step, and simulates balls that slide. With "own", it adds
        nothing to Pymunk's steps.

    `dt`: 1e-3 s tuned; 1/60 s naive, as in Pymunk's examples; 0.02 s with exact steps.
    `iterations`: 30 tuned; 10 naive, Chipmunk's default.
    """


class PymunkEngine(PlaneEngine):
    """Pymunk as a reference engine; see this module."""

    name: ClassVar[str] = "pymunk"
    WORLD: ClassVar[str] = "PymunkWorld"
    Settings: ClassVar[type[EngineSettings]] = PymunkSettings
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "pymunk")

    @classmethod
    def unavailable(cls) -> str | None:
        """Return how to install Pymunk if it is missing, or None."""
        if importlib.util.find_spec("pymunk") is not None:
            return None
        return "the package `pymunk` is not installed. Install it with: pip install 'pymunk>=7'"

    def stepper(self, scene: Scene, world: Any) -> WorldStepper:
        """Return the stepper of a world: for balls that only roll, one with Pymunk's joints."""
        if self.settings.contact_steps == "fixed" and scene.physics.motion == "rolling":
            return JointStepper(
                scene,
                world,
                self.step(scene),
                end_of(scene, self.settings),
                joints=self.settings.config == "tuned",
                leapfrog=self.settings.cloth == "closed-form",
            )
        return super().stepper(scene, world)
