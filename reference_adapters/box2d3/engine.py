"""Box2D 3: a 2D engine in single precision, another solver than that of Box2D 2.3.

It solves contacts before balls touch ("speculative", up to 0.02 units), in soft sub-steps, and
applies restitution once, after the solver. So a single impact keeps its energy, and contacts that
share a ball lose it: a break keeps half, at any step. Tuned, a metre has 100 units, impacts have no
threshold, and bodies may go as fast as they like. `config="naive"` is what a newcomer types:
metres, frames of 1/60 s, and impacts slower than 1 m/s are inelastic.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from ghostball.model import Scene
from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.stepping.ends import IN_SINGLE_PRECISION, ExactSteps
from ghostball.reference_adapters.stepping.laws import restitutions
from ghostball.reference_adapters.stepping.plane_engine import PlaneEngine
from ghostball.reference_adapters.stepping.settings import SteppingSettings


class Box2d3Settings(SteppingSettings):
    """Settings of the Box2D 3 adapter.

    `dt` is 1e-3 s tuned, 1/60 s naive as in Box2D's manual, 0.02 s in exact steps; `iterations`
    are sub-steps: 4, as the manual has it.
    """

    EXACT_IF_NAIVE: ClassVar[bool] = False

    @property
    def units(self) -> float:
        """Units of Box2D in a metre [1/m]."""
        return 100.0 if self.config == "tuned" else 1.0


class Box2d3Engine(PlaneEngine):
    """Box2D 3 behind the protocol; see the module."""

    name: ClassVar[str] = "box2d3"
    PACKAGE: ClassVar[str] = "pyb2d3"
    Settings: ClassVar[type[EngineSettings]] = Box2d3Settings
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "box2d3")
    EXACT_STEPS: ClassVar[ExactSteps] = IN_SINGLE_PRECISION

    def _lacking(self, scene: Scene) -> Iterator[str]:
        yield from super()._lacking(scene)
        balls, cushions = restitutions(scene.physics)
        if scene.table is not None and cushions < balls:
            yield (
                "no cushions with less restitution than the balls (Box2D uses the larger of the "
                "two)"
            )
