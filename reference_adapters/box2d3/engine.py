"""Box2D 3: a 2D engine in single precision with a different solver from Box2D 2.3.

It resolves contacts before balls touch ("speculative", up to 0.02 units), in soft sub-steps, and
applies restitution once, after the solver. So single impacts conserve energy, but simultaneous
contacts lose energy: a break loses half, at any time step. With `config="tuned"`, a metre has 100
units, no impact is too slow to rebound, and no ball reaches Box2D's speed limit. `config="naive"`
is what a newcomer types: metres, time steps of 1/60 s, and inelastic impacts below 1 m/s.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from ghostball.model import Scene
from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.stepping.laws import restitutions
from ghostball.reference_adapters.stepping.plane_engine import PlaneEngine
from ghostball.reference_adapters.stepping.settings import SteppingSettings
from ghostball.reference_adapters.stepping.step_ends import SINGLE_PRECISION_STEPS, ExactSteps


class Box2d3Settings(SteppingSettings):
    """Settings of the Box2D 3 adapter.

    `dt`: 1e-3 s tuned; 1/60 s naive, as in Box2D's manual; 0.02 s with exact steps.
    `iterations`: number of sub-steps; 4, as in the manual.
    """

    EXACT_IF_NAIVE: ClassVar[bool] = False

    @property
    def units(self) -> float:
        """Number of units of Box2D per metre [1/m]."""
        return 100.0 if self.config == "tuned" else 1.0


class Box2d3Engine(PlaneEngine):
    """Box2D 3 as a reference engine; see this module."""

    name: ClassVar[str] = "box2d3"
    PACKAGE: ClassVar[str] = "pyb2d3"
    WORLD: ClassVar[str] = "Box2d3World"
    Settings: ClassVar[type[EngineSettings]] = Box2d3Settings
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "box2d3")
    EXACT_STEPS: ClassVar[ExactSteps] = SINGLE_PRECISION_STEPS

    def _lacking(self, scene: Scene) -> Iterator[str]:
        yield from super()._lacking(scene)
        balls, cushions = restitutions(scene.physics)
        if scene.table is not None and cushions < balls:
            yield (
                "no cushions with a lower restitution than the balls (Box2D uses the larger of the "
                "two)"
            )
