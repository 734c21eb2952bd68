"""Pymunk (Chipmunk): a 2D engine with fixed steps, that sees the table from above.

A contact is seen when a step ends in overlap: late by up to a step, after the balls have passed the
point of contact, which makes cut shots come out too thin. `contact_steps="fixed"` is that: what a
user of Pymunk gets. `contact_steps="exact"` ends the steps where balls touch, so that only the
solver's own error remains. `config="tuned"` is the best use of Pymunk that experiments found,
`config="naive"` what a newcomer types.
"""

from __future__ import annotations

import importlib.util
from typing import Any, ClassVar

from ghostball.model import Scene
from ghostball.model.features import EXACT, Capabilities, Capability, Feature
from ghostball.reference_adapters.base import EngineSettings, none
from ghostball.reference_adapters.pymunk.steppers import NativeRolling
from ghostball.reference_adapters.stepping.ending import end_of
from ghostball.reference_adapters.stepping.plane import Stepper
from ghostball.reference_adapters.stepping.plane_engine import (
    PlaneEngine,
    disc_capabilities,
    naive_capabilities,
)
from ghostball.reference_adapters.stepping.settings import SteppingSettings


class PymunkSettings(SteppingSettings):
    """Settings of the Pymunk adapter.

    `iterations` is 30 tuned, Chipmunk's 10 naive; `dt` is 1e-3 s tuned, 1/60 s naive as in
    Pymunk's examples, 0.02 s in exact steps.
    """


_RUBS = (
    "Chipmunk's own friction along the contact, with the share of the coefficient that belongs to "
    "it; the adapter turns the balls by the share up or down, of which Chipmunk's plane knows "
    "nothing. A single impact is exact; where several meet, the share is that before them all"
)
_MULTIPLIED = Capability(
    "approximate", "elasticities set as a newcomer does: Chipmunk multiplies those of the two"
)
_PARTS = Capability(
    "exact",
    "segments without thickness, whose ends are points, and circles; a ball that goes farther than "
    "its radius in a step can pass through a segment",
)

_TUNED: Capabilities = {
    **disc_capabilities("Pymunk", EXACT, Capability("approximate", _RUBS), _PARTS),
    Feature.SPEED_DEPENDENT_FRICTION: Capability(
        "approximate", f"the coefficient of the slip before the impact, as in the law. {_RUBS}"
    ),
    Feature.AIR_DRAG: none("Pymunk damps in proportion to speed, not to its square"),
}

_NAIVE: Capabilities = {
    **naive_capabilities(_TUNED, "Pymunk", _MULTIPLIED),
    Feature.OPEN_SIDES: Capability("approximate", "cushions end at the table's corners"),
}


class PymunkEngine(PlaneEngine):
    """Pymunk behind the protocol; see the module."""

    name: ClassVar[str] = "pymunk"
    WORLD: ClassVar[str] = "ghostball.reference_adapters.pymunk.world:World"
    Settings: ClassVar[type[EngineSettings]] = PymunkSettings
    TUNED: ClassVar[Capabilities] = _TUNED
    NAIVE: ClassVar[Capabilities] = _NAIVE

    @classmethod
    def unavailable(cls) -> str | None:
        """Return how to get Pymunk where it isn't installed, or None."""
        if importlib.util.find_spec("pymunk") is not None:
            return None
        return "the package `pymunk` is not installed. Install it with: pip install 'pymunk>=7'"

    def stepper(self, scene: Scene, world: Any) -> Stepper:
        """Return what moves the balls on: balls that only roll, by Pymunk's own means."""
        if self.settings.contact_steps == "fixed" and scene.physics.motion == "rolling":
            return NativeRolling(scene, world, self.step(scene), end_of(scene, self.settings))
        return super().stepper(scene, world)
