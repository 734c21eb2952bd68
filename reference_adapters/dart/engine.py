"""DART: a 3D engine which solves impacts and friction as one boxed linear complementarity problem.

Two constants are compiled in, in a unit of length of its own: rebounds below 0.1 unit/s are
suppressed, those above 100 units/s clipped. `scale` is the number of units per metre.
`contact_steps="fixed"` detects contacts when balls overlap at the start of a step;
`contact_steps="exact"` ends the steps when balls touch. `cloth="own"` lets balls slide on a plane
under gravity with DART's friction; otherwise the adapter applies cloth friction between time steps.
`config="naive"` is what a newcomer types: metres, and the restitution set on both bodies, although
DART multiplies the two.
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
"""Faster rebounds are clipped to this speed [units/s]."""


class DartSettings(OwnClothSettings):
    """Settings of the DART adapter.

    `dt`: 1e-3 s, DART's default; 0.02 s with exact steps. `iterations` has no effect, because DART
        uses a direct solver.
    `scale`: units of DART per metre [1/m]. None: as many as the scene's fastest ball allows, at
        most 10; 1 in the naive configuration.
    """

    NAIVE_DT: ClassVar[float] = 1e-3

    scale: Annotated[float, Field(gt=0.0, le=1e4)] | None = None

    def units(self, scene: Scene) -> float:
        """Return the number of units per metre for a scene [1/m]."""
        if self.scale is not None:
            return self.scale
        if self.config == "naive":
            return 1.0
        # Two balls that share all the energy approach at sqrt(2) times the speed of one with all of
        # it.
        return min(10.0, FASTEST_REBOUND / max(1.5 * fastest(scene), 1e-9))


class DartEngine(OwnClothEngine):
    """DART as a reference engine; see this module."""

    name: ClassVar[str] = "dart"
    PACKAGE: ClassVar[str] = "dartpy"
    WORLD: ClassVar[str] = "DartWorld"
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
                "clips rebounds at 100 units/s)"
            )
        if self.own_cloth(scene) and len(scene.balls) > 1:
            yield (
                "no impacts between balls with `cloth` = own (DART uses the smaller of two "
                "friction coefficients, so cloth friction implies friction between balls)"
            )
