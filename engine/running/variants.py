"""Which variant of the compiled kernels a scene needs: each leaves out what its scenes don't."""

from __future__ import annotations

from typing import Any, NamedTuple

from ghostball.engine.running.skips import Skip, has_drag
from ghostball.model import Ball, Physics, Scene


class Variant(NamedTuple):
    """What the compiled kernels contain, and what is left out of them."""

    drag: bool = False  # motion that is no parabola, by air
    flight: bool = False  # balls that leave the cloth

    def name(self, what: str) -> str:
        """Return how a message calls the kernels of `what`."""
        extras = ["air"] * self.drag + ["flight"] * self.flight
        return what + " with " * bool(extras) + ", ".join(extras)


def variant_of(scene: Scene, off: frozenset[Skip] = frozenset()) -> Variant:
    """Return what the kernels need to contain for a scene, with the skips in `off` switched off."""
    return Variant(
        has_drag(scene) or Skip.DRAG in off,
        scene.physics.airborne or Skip.FLIGHT in off,
    )


def still_scene(variant: Variant) -> Scene:
    """Return a scene in which nothing happens."""
    laws: dict[str, Any] = {}
    if variant.flight:
        laws |= {"motion": "sliding", "airborne": True}
    if variant.drag:
        laws["rolling_friction_quadratic"] = 0.004
    balls = (Ball(id="still", position=(0.0, 0.0)),)
    return Scene(name="warm-up", balls=balls, physics=Physics(**laws))
