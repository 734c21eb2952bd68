"""Pymunk (Chipmunk): a 2D engine with fixed steps, that sees the table from above.

A contact is seen when a step ends in overlap: late by up to a step, after the balls have passed the
point of contact, which makes cut shots come out too thin. `contact_steps="fixed"` is that: what a
user of Pymunk gets. `contact_steps="exact"` ends the steps where balls touch, so that only the
solver's own error remains. `config="tuned"` is the best use of Pymunk that experiments found,
`config="naive"` what a newcomer types.
"""

from __future__ import annotations

import importlib.util
from typing import Any, ClassVar

from ghostball.model import Scene
from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.pymunk.steppers import NativeRolling
from ghostball.reference_adapters.stepping.ending import end_of
from ghostball.reference_adapters.stepping.plane import Stepper
from ghostball.reference_adapters.stepping.plane_engine import PlaneEngine
from ghostball.reference_adapters.stepping.settings import SteppingSettings


class PymunkSettings(SteppingSettings):
    """Settings of the Pymunk adapter.

    `iterations` is 30 tuned, Chipmunk's 10 naive; `dt` is 1e-3 s tuned, 1/60 s naive as in
    Pymunk's examples, 0.02 s in exact steps.
    """


class PymunkEngine(PlaneEngine):
    """Pymunk behind the protocol; see the module."""

    name: ClassVar[str] = "pymunk"
    Settings: ClassVar[type[EngineSettings]] = PymunkSettings
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "pymunk")

    @classmethod
    def unavailable(cls) -> str | None:
        """Return how to get Pymunk where it isn't installed, or None."""
        if importlib.util.find_spec("pymunk") is not None:
            return None
        return "the package `pymunk` is not installed. Install it with: pip install 'pymunk>=7'"

    def stepper(self, scene: Scene, world: Any) -> Stepper:
        """Return what moves the balls on: balls that only roll, by Pymunk's own means."""
        if self.settings.contact_steps == "fixed" and scene.physics.motion == "rolling":
            return NativeRolling(scene, world, self.step(scene), end_of(scene, self.settings))
        return super().stepper(scene, world)
