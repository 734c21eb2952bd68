"""Kernels that given scenes need, so that they can be compiled before any shot is simulated.

Each scene needs one of two kernels (`running.variants`), which can be compiled at the same time. A
kernel that is still missing when a shot needs it is compiled then.
"""

from __future__ import annotations

from collections.abc import Iterable

from ghostball.engine.library.entry import Needed
from ghostball.engine.running import driver
from ghostball.engine.running.variants import Variant, still_scene, variant_of
from ghostball.engine.shot import MAX_EVENTS, check_request
from ghostball.model import Scene
from ghostball.model.errors import GhostballError


def kernels_of(scenes: Iterable[Scene]) -> list[Needed]:
    """Return the kernels that `scenes` need.

    A scene that this engine can't simulate needs no kernels.
    """
    shots: dict[Variant, None] = {}
    for scene in scenes:
        try:
            check_request(scene, "rest", MAX_EVENTS)
        except GhostballError:
            continue
        shots.setdefault(variant_of(scene))
    return [driver.needed(variant) for variant in shots]


def warm_up(scenes: Iterable[Scene] = ()) -> None:
    """Compile or load the kernels that `scenes` need now, instead of in the first `simulate`.

    A message announces a compilation. Without `scenes`, only the kernel for a shot of one ball is
    loaded.
    """
    scenes = tuple(scenes) or (still_scene(Variant.LEAN),)
    for needed in kernels_of(scenes):
        needed.load()


def every_kernel() -> list[Needed]:
    """Return both kernels, the one that takes longer to compile first."""
    return [driver.needed(variant) for variant in (Variant.FULL, Variant.LEAN)]
