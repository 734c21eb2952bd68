"""Engines that a board must tell from right ones, and survive."""

import os
from dataclasses import replace
from typing import ClassVar

from ghostball.engine import simulate
from ghostball.model.features import EXACT, Feature
from ghostball.reference_adapters import EngineBase, EngineSettings


class Slowing(EngineBase):
    """Our engine, but that balls bounce off each other with a restitution of 0.8."""

    name: ClassVar[str] = "slowing"
    Settings: ClassVar[type[EngineSettings]] = EngineSettings

    @property
    def capabilities(self):
        return dict.fromkeys(Feature, EXACT)

    def simulate(self, scene, *, record="rest"):
        self.check(scene)
        physics = scene.physics.model_copy(update={"ball_restitution": 0.8})
        result = simulate(scene.model_copy(update={"physics": physics}), record=record)
        return replace(result, engine=self.name, scene=scene)


class Dying(Slowing):
    """An engine that takes its process with it."""

    name: ClassVar[str] = "dying"

    def simulate(self, scene, *, record="rest"):
        os._exit(3)
