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
from typing import Annotated, ClassVar, Self

from pydantic import Field, model_validator

from ghostball.model import Scene
from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.stepping.ends import IN_SINGLE_PRECISION, ExactSteps
from ghostball.reference_adapters.stepping.laws import fastest
from ghostball.reference_adapters.stepping.plane_engine import PlaneEngine
from ghostball.reference_adapters.stepping.settings import SteppingSettings

FARTHEST = 2.0
"""How far a body goes in a step at most: `b2_maxTranslation` [units]."""

FINEST = 200.0
"""Units in a metre that `scale` stands for where the step allows that many [1/m]."""

SLOP = 0.005
"""Overlap that Box2D leaves: `b2_linearSlop` [units]."""


class Box2dSettings(SteppingSettings):
    """Settings of the Box2D adapter.

    `dt` is 1e-3 s tuned, 1/60 s naive as in Box2D's manual, 0.02 s or what the scale allows
    to contacts; `iterations` are of velocities: 8 tuned, as the manual recommends, 6 naive.

    `scale` [1/m]: units of Box2D in a metre. None is as many as the step and the scene's fastest
        ball allow, at most 200; 1 in the naive configuration.
    `bullet`: whether balls are bullets: contacts between them are found in continuous time. Where
        steps end at contacts, and in the naive configuration, they never are.
    """

    scale: Annotated[float, Field(gt=0.0, le=1e4)] | None = None
    bullet: bool = True

    @model_validator(mode="after")
    def _naive_is_in_metres(self) -> Self:
        if self.config == "naive" and self.scale is not None:
            raise ValueError(
                "`config` = naive is in metres: leave `scale` out, or set `config` = tuned"
            )
        return self

    @property
    def bullets(self) -> bool:
        """Whether balls are bullets, with these settings."""
        return self.bullet and self.contact_steps == "fixed" and self.config == "tuned"

    def units(self, scene: Scene) -> float:
        """Return the units in a metre for a scene [1/m]."""
        if self.config == "naive":
            return 1.0
        if self.scale is not None:
            return self.scale
        if self.contact_steps == "exact":
            return 100.0
        return min(FINEST, 0.9 * FARTHEST / max(fastest(scene) * self.step, 1e-9))


class Box2dEngine(PlaneEngine):
    """Box2D 2.3 behind the protocol; see the module."""

    name: ClassVar[str] = "box2d"
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
