"""Settings of the Box2D 2.3 adapter, and constants of Box2D's that they depend on."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from ghostball.model import Scene
from ghostball.reference_adapters.stepping.laws import fastest
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
