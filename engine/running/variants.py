"""Choice between the two compiled kernels: the lean one has no air and no flight."""

from __future__ import annotations

import enum
from typing import Any

from ghostball.engine.running.skips import Skip, is_lean
from ghostball.model import Ball, Physics, Scene


class Variant(enum.Enum):
    """A kernel of shots; the value is its name in messages."""

    LEAN = "shots"
    FULL = "shots in air and in flight"  # pieces of any degree, and balls that leave the cloth


def variant_of(scene: Scene, off: frozenset[Skip] = frozenset()) -> Variant:
    """Return the kernel that a scene needs, with the skips in `off` switched off."""
    return Variant.LEAN if is_lean(scene) and Skip.AIR_AND_FLIGHT not in off else Variant.FULL


def still_scene(variant: Variant) -> Scene:
    """Return a scene in which nothing happens."""
    laws: dict[str, Any] = {}
    if variant is Variant.FULL:
        laws = {"motion": "sliding", "airborne": True}
    balls = (Ball(id="still", position=(0.0, 0.0)),)
    return Scene(name="warm-up", balls=balls, physics=Physics(**laws))
