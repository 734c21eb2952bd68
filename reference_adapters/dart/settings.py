"""Settings of the DART adapter."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from ghostball.model import Scene
from ghostball.reference_adapters.stepping.laws import fastest
from ghostball.reference_adapters.stepping.settings import OwnClothSettings

FASTEST_REBOUND = 100.0
"""Rebounds faster than this are cut to it [units/s]."""


class DartSettings(OwnClothSettings):
    """Settings of the DART adapter.

    `dt` is 1e-3 s, as DART's own; 0.02 s in exact steps. There are no `iterations`: DART solves
    directly.

    `scale` [1/m]: units of DART in a metre. None is as many as the scene's fastest ball allows, at
    most 10; 1 in the naive configuration.
    """

    NAIVE_DT: ClassVar[float] = 1e-3

    scale: Annotated[float, Field(gt=0.0, le=1e4)] | None = None

    def units(self, scene: Scene) -> float:
        """Return the units in a metre for a scene [1/m]."""
        if self.scale is not None:
            return self.scale
        if self.config == "naive":
            return 1.0
        # Two balls that share all energy meet at sqrt(2) times what one has with it.
        return min(10.0, FASTEST_REBOUND / max(1.5 * fastest(scene), 1e-9))
