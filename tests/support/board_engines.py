"""Engines that a board must tell from right ones, and survive."""

import os
from dataclasses import replace
from typing import ClassVar

from ghostball.engine import simulate
from ghostball.engine.scene.features import EXACT, Feature
from ghostball.reference_adapters import EngineBase, EngineSettings


class Slowing(EngineBase):
    """Our engine, but that the balls end with 10 % less speed than they have."""

    name: ClassVar[str] = "slowing"
    Settings: ClassVar[type[EngineSettings]] = EngineSettings

    @property
    def capabilities(self):
        return dict.fromkeys(Feature, EXACT)

    def simulate(self, scene, *, record="rest"):
        self.check(scene)
        result = simulate(scene, record=record)
        end = result.final_state
        slower = end._replace(velocities=0.9 * end.velocities)
        return replace(result, engine=self.name, final_state=slower)


class Dying(Slowing):
    """An engine that takes its process with it."""

    name: ClassVar[str] = "dying"

    def simulate(self, scene, *, record="rest"):
        os._exit(3)
