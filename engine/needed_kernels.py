"""What given scenes need of the kernels, so that it can be compiled before any shot is played.

A variant leaves out what a scene doesn't need (`running.variants`). Variants can be compiled side
by side, and whoever needs one that isn't compiled yet compiles it then.
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
    """Return what `scenes` need of the kernels.

    `scenes`: one that this engine can't play needs nothing.
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
    """Compile or load the kernels that `scenes` need now, rather than in the first `simulate`.

    A compilation is announced. Without scenes: what a shot of one ball needs.
    """
    scenes = tuple(scenes) or (still_scene(Variant.LEAN),)
    for needed in kernels_of(scenes):
        needed.load()


def every_kernel() -> list[Needed]:
    """Return both kernels, the one that takes longer to compile first."""
    return [driver.needed(variant) for variant in (Variant.FULL, Variant.LEAN)]
