"""DART: a 3D engine whose impacts and friction are one boxed linear complementarity problem.

Two constants are compiled in, in its own unit of length: rebounds slower than 0.1 unit/s are left
out, faster than 100 units/s are cut. `scale` says how many units a metre has.
`contact_steps="fixed"` sees contacts when balls overlap as a step begins; `contact_steps="exact"`
ends the steps where balls touch. `cloth="own"` has balls slide on a plane under gravity, with
DART's friction; else the adapter applies the cloth between the steps. `config="naive"` is what a
newcomer types: metres, and the restitution on both bodies, of which DART takes the product.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar

from pydantic import Field

from ghostball.model import Scene
from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.stepping.laws import fastest
from ghostball.reference_adapters.stepping.settings import OwnClothSettings
from ghostball.reference_adapters.stepping.space import OwnClothEngine

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


class DartEngine(OwnClothEngine):
    """DART behind the protocol; see the module."""

    name: ClassVar[str] = "dart"
    PACKAGE: ClassVar[str] = "dartpy"
    Settings: ClassVar[type[EngineSettings]] = DartSettings
    TITLE: ClassVar[str] = "DART"
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "dart")

    def _lacking(self, scene: Scene) -> Iterator[str]:
        yield from super()._lacking(scene)
        settings: DartSettings = self.settings
        most = FASTEST_REBOUND / settings.units(scene)
        if fastest(scene) > most:
            yield (
                f"no speeds above {most:.3g} m/s with `scale` = {settings.units(scene):g} (DART "
                "cuts rebounds to 100 units/s)"
            )
        if self.own_cloth(scene) and len(scene.balls) > 1:
            yield (
                "no impacts between balls with `cloth` = own (DART takes the smaller of two "
                "coefficients of friction, so balls that rub on the cloth rub on each other)"
            )
