"""Our own engine behind the protocol that the foreign ones follow."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from engine import Record, Result, Scene, simulate
from engine.features import Capabilities
from engine.simulate import CAPABILITIES, MAX_EVENTS
from reference_adapters.base import EngineBase, EngineSettings


class GhostballSettings(EngineSettings):
    """Settings of our engine: it has no time step and no tolerance to choose."""

    max_events: Annotated[int, Field(gt=0)] = MAX_EVENTS
    """Events after which a run stops with `Status.EVENT_LIMIT`."""


class GhostballEngine(EngineBase):
    """Continuous collision detection in closed form; see the package `engine`."""

    name: ClassVar[str] = "ghostball"
    Settings: ClassVar[type[EngineSettings]] = GhostballSettings

    @property
    def capabilities(self) -> Capabilities:
        """How each feature of a scene is represented; the same with all settings."""
        return CAPABILITIES

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Run the scene; see `engine.simulate`."""
        return simulate(scene, record=record, max_events=self.settings.max_events)
