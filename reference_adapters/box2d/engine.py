"""Box2D 2.3: a 2D engine in single precision (top view of the table).

Several constants are compiled in, in a unit of length of its own: collisions slower than 1 unit/s
are inelastic, a body moves at most 2 units per time step, and an overlap of 0.005 units is
tolerated. A unit must therefore be much smaller than a metre: `scale` is the number of units per
metre. `contact_steps="fixed"` uses Box2D's own contact detection (tuned: continuous, "bullets");
`contact_steps="exact"` ends the steps when balls touch. `config="naive"` is what a newcomer types:
metres, time steps of 1/60 s, no bullets.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Self

from pydantic import Field, model_validator

from ghostball.model import Scene
from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.stepping.joints import JointStepper
from ghostball.reference_adapters.stepping.laws import fastest
from ghostball.reference_adapters.stepping.plane import WorldStepper
from ghostball.reference_adapters.stepping.plane_engine import PlaneEngine
from ghostball.reference_adapters.stepping.run_end import end_of
from ghostball.reference_adapters.stepping.settings import OwnClothSettings
from ghostball.reference_adapters.stepping.step_ends import SINGLE_PRECISION_STEPS, ExactSteps

MAX_TRANSLATION = 2.0
"""Largest distance that a body moves per step: `b2_maxTranslation` [units]."""

MAX_SCALE = 200.0
"""Largest default of `scale`, if the time step allows it [1/m]."""

JOINT_ROUNDING = 1e-4
"""Speed of a ball that a joint has stopped, relative to the joint's effect per step [1]."""

SLOP = 0.005
"""Overlap that Box2D tolerates: `b2_linearSlop` [units]."""


class Box2dSettings(OwnClothSettings):
    """Settings of the Box2D adapter.

    `cloth`: with "own", Box2D's friction joints slow balls, which only roll; see
        `OwnClothSettings`.

    `dt`: 1e-3 s tuned; 1/60 s naive, as in Box2D's manual; with exact steps, 0.02 s or the longest
        step that the scale allows.
    `iterations`: velocity iterations; 8 tuned, as the manual recommends, 6 naive.
    `scale`: units of Box2D per metre [1/m]. None: as many as the time step and the scene's fastest
        ball allow, at most 200; 1 in the naive configuration.
    `bullet`: whether balls are bullets, which detect contacts with each other in continuous time.
        With exact steps, and in the naive configuration, they never are.
    """

    scale: Annotated[float, Field(gt=0.0, le=1e4)] | None = None
    bullet: bool = True

    @model_validator(mode="after")
    def _naive_is_in_metres(self) -> Self:
        if self.config == "naive" and self.scale is not None:
            raise ValueError(
                "`config` = naive uses metres: remove `scale`, or set `config` = tuned"
            )
        return self

    @property
    def bullets(self) -> bool:
        """Whether balls are bullets with these settings."""
        return self.bullet and self.contact_steps == "fixed" and self.config == "tuned"

    def units(self, scene: Scene) -> float:
        """Return the number of units per metre for a scene [1/m]."""
        if self.config == "naive":
            return 1.0
        if self.scale is not None:
            return self.scale
        if self.contact_steps == "exact":
            return 100.0
        return min(MAX_SCALE, 0.9 * MAX_TRANSLATION / max(fastest(scene) * self.step, 1e-9))


class Box2dEngine(PlaneEngine):
    """Box2D 2.3 as a reference engine; see this module."""

    name: ClassVar[str] = "box2d"
    PACKAGE: ClassVar[str] = "Box2D"
    WORLD: ClassVar[str] = "Box2dWorld"
    Settings: ClassVar[type[EngineSettings]] = Box2dSettings
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "box2d")
    EXACT_STEPS: ClassVar[ExactSteps] = SINGLE_PRECISION_STEPS

    def _lacking(self, scene: Scene) -> Iterator[str]:
        yield from super()._lacking(scene)
        settings: Box2dSettings = self.settings
        most = MAX_TRANSLATION / (settings.units(scene) * self.step(scene))
        if fastest(scene) > most:
            yield (
                f"no speeds above {most:.3g} m/s with `scale` = {settings.units(scene):g} and "
                f"steps of {self.step(scene):g} s (Box2D moves a body at most 2 units per time "
                f"step; the energy in this scene allows speeds up to {fastest(scene):.3g} m/s)"
            )

    def stepper(self, scene: Scene, world: Any) -> WorldStepper:
        """Return the stepper of a world: with its own cloth, one with Box2D's joints."""
        if self.settings.cloth == "closed-form":
            return super().stepper(scene, world)
        t_end = end_of(scene, self.settings)
        dt = self.step(scene)
        return JointStepper(scene, world, dt, t_end, leapfrog=False, rounding=JOINT_ROUNDING)

    def resolution(self, scene: Scene) -> float:
        """Return the distance that a ball moves in a step [m], or the gap at which steps end.

        Bullets meet in continuous time, with an overlap of 3 slops.
        """
        settings: Box2dSettings = self.settings
        if settings.bullets:
            return 3.0 * SLOP / settings.units(scene)
        return super().resolution(scene)

    def step(self, scene: Scene) -> float:
        """Return the time step [s]; with exact steps, one within Box2D's limit on distances."""
        settings: Box2dSettings = self.settings
        if settings.contact_steps == "fixed":
            return settings.step
        speed = max(fastest(scene), 1e-9)
        return min(settings.step, 0.9 * MAX_TRANSLATION / (settings.units(scene) * speed))
