"""Which variant of the compiled kernels a scene needs: each leaves out what its scenes don't."""

from __future__ import annotations

from typing import Any, NamedTuple

from ghostball.engine.running import skips
from ghostball.engine.running.skips import Skip, is_integrated, uses_cells
from ghostball.engine.scene import Ball, Physics, Scene


class Variant(NamedTuple):
    """What the compiled kernels contain, and what is left out of them."""

    cells: bool  # the scheduler for many balls, else the one for few
    integrated: bool  # the laws that integrate over the impact
    contacts: bool  # joint impacts and sustained contact

    def name(self, what: str) -> str:
        """Return how a message calls the kernels of `what`."""
        extras = ["contacts"] * self.contacts + ["cells"] * self.cells
        extras += ["integrated laws"] * self.integrated
        return what + " with " * bool(extras) + ", ".join(extras)


def variant_of(scene: Scene, contacts: bool, off: frozenset[Skip] = frozenset()) -> Variant:
    """Return what the kernels need to contain for a scene, with the skips in `off` switched off."""
    return Variant(
        uses_cells(scene, off),
        is_integrated(scene) or Skip.INTEGRATED_LAWS in off,
        contacts or Skip.CONTACTS in off,
    )


def still_scene(variant: Variant) -> Scene:
    """Return a scene in which nothing happens."""
    laws: dict[str, Any] = {}
    if variant.integrated:
        laws = {"motion": "sliding", "cushion": "mathavan2010"}
    count = skips.MOST_PAIRED + 1 if variant.cells else 1
    balls = tuple(Ball(id=f"still {k}", position=(float(k), 0.0)) for k in range(count))
    return Scene(name="warm-up", balls=balls, physics=Physics(**laws))
