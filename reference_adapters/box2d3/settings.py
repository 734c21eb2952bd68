"""Settings of the Box2D 3 adapter."""

from __future__ import annotations

from typing import ClassVar

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
