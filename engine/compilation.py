"""Compiles, before any shot is played, the variants of the kernels that given scenes need.

A variant leaves out what a scene doesn't need (`running.variants`). Variants can be compiled side
by side, each in a process of its own, and whoever needs one that isn't compiled yet compiles it
then.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from ghostball.engine.running.variants import Variant, still_scene, variant_of
from ghostball.engine.shot import MAX_EVENTS, check_request
from ghostball.model import Scene
from ghostball.model.errors import GhostballError

MANY = 3
"""Balls from which on joint impacts and sustained contact are likely: two seldom come to them."""


@dataclass(frozen=True)
class Variants:
    """Variants of one kind of kernels that belong together; one process compiles them.

    Attributes
    ----------
    scene : Scene
        One of those that need them.
    contacts : bool
        Whether they may come to joint impacts or to sustained contact. A run begins with kernels
        that know neither; those that do are compiled too, and share with them what they can.
    tangents : bool
        Whether they are the kernels of the tangent map, not those of shots.
    """

    scene: Scene
    contacts: bool = False
    tangents: bool = False

    @property
    def names(self) -> list[str]:
        """What messages, and the cache, call these variants."""
        from ghostball.engine.sensitivity.tangent_map import variant_name  # noqa: PLC0415 - loads the compiler

        if self.tangents:
            return [variant_name(self.scene)]
        return [variant_of(self.scene, each).name("shots") for each in self._each]

    @property
    def are_compiled(self) -> bool:
        """Whether all of them are in the cache."""
        from ghostball.engine.core.kernel import compiled  # noqa: PLC0415

        return all(compiled(name) for name in self.names)

    def compile(self) -> None:
        """Compile them, or load what is in the cache; nothing is played but a still ball."""
        from ghostball.engine.running import driver  # noqa: PLC0415
        from ghostball.engine.sensitivity import tangent_map  # noqa: PLC0415

        if self.tangents:
            tangent_map.warm_up(self.scene)
            return
        for each in self._each:
            driver.warm_up(variant_of(self.scene, each))

    @property
    def _each(self) -> tuple[bool, ...]:
        """For each variant of shots, whether it knows contacts."""
        return (False, True) if self.contacts else (False,)


def variants_of(
    scenes: Iterable[Scene], *, tangents: bool = False, contacts_from: int = 2
) -> list[Variants]:
    """Return what `scenes` need of the kernels.

    Parameters
    ----------
    scenes : iterable of Scene
        One that this engine can't play needs nothing.
    tangents : bool
        Whether the kernels of the tangent map are needed too (`Result.sensitivity`).
    contacts_from : int
        Number of balls from which on a scene is taken to come to joint impacts or to sustained
        contact. Where one with fewer does, what it needs is compiled then.
    """
    from ghostball.engine.sensitivity.tangent_map import has_derivative, variant_name  # noqa: PLC0415

    shots: dict[str, Variants] = {}
    maps: dict[str, Variants] = {}
    for scene in scenes:
        try:
            check_request(scene, "rest", MAX_EVENTS)
        except GhostballError:
            continue
        contacts = len(scene.balls) >= contacts_from
        name = variant_of(scene, contacts=False).name("shots")
        if name not in shots or (contacts and not shots[name].contacts):
            shots[name] = Variants(scene, contacts)
        if tangents and has_derivative(scene):
            maps.setdefault(variant_name(scene), Variants(scene, tangents=True))
    return [*shots.values(), *maps.values()]


def warm_up(scenes: Iterable[Scene] = ()) -> None:
    """Compile or load the kernels that `scenes` need now, rather than in the first `simulate`.

    A compilation is announced. Without scenes: what a shot of one ball needs.
    """
    scenes = tuple(scenes) or (still_scene(Variant(False, False, False)),)
    for variants in variants_of(scenes):
        variants.compile()
