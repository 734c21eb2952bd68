"""Box2D 2.3: a 2D engine in single precision, that sees the table from above.

Its constants are compiled in, in its own unit of length: impacts slower than 1 unit/s are
inelastic, a body goes at most 2 units a step, and an overlap of 0.005 units is left. So a unit must
be far less than a metre: `scale` says how many units a metre has. `contact_steps="fixed"` finds
contacts as Box2D does, tuned in continuous time ("bullets"); `contact_steps="exact"` ends the steps
where balls touch. `config="naive"` is what a newcomer types: metres, frames of 1/60 s, no
bullets.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from ghostball.model import Scene
from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.box2d.settings import FARTHEST, SLOP, Box2dSettings
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.stepping.ends import IN_SINGLE_PRECISION, ExactSteps
from ghostball.reference_adapters.stepping.laws import fastest
from ghostball.reference_adapters.stepping.plane_engine import PlaneEngine


class Box2dEngine(PlaneEngine):
    """Box2D 2.3 behind the protocol; see the module."""

    name: ClassVar[str] = "box2d"
    WORLD: ClassVar[str] = "ghostball.reference_adapters.box2d.world:World"
    PACKAGE: ClassVar[str] = "Box2D"
    Settings: ClassVar[type[EngineSettings]] = Box2dSettings
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "box2d")
    EXACT_STEPS: ClassVar[ExactSteps] = IN_SINGLE_PRECISION

    def _lacking(self, scene: Scene) -> Iterator[str]:
        yield from super()._lacking(scene)
        settings: Box2dSettings = self.settings
        most = FARTHEST / (settings.units(scene) * self.step(scene))
        if fastest(scene) > most:
            yield (
                f"no speeds above {most:.3g} m/s with `scale` = {settings.units(scene):g} and "
                f"steps of {self.step(scene):g} s (Box2D moves a body by 2 units a step at most; "
                f"the energy of these balls would do for {fastest(scene):.3g} m/s)"
            )

    def resolution(self, scene: Scene) -> float:
        """Return how far a ball goes in a step [m]; or how far from a contact its step ends.

        Bullets meet in continuous time, but with an overlap of 3 slops.
        """
        settings: Box2dSettings = self.settings
        if settings.bullets:
            return 3.0 * SLOP / settings.units(scene)
        return super().resolution(scene)

    def step(self, scene: Scene) -> float:
        """Return the step [s]; if it ends at contacts, one within Box2D's bound on ways."""
        settings: Box2dSettings = self.settings
        if settings.contact_steps == "fixed":
            return settings.step
        speed = max(fastest(scene), 1e-9)
        return min(settings.step, 0.9 * FARTHEST / (settings.units(scene) * speed))
