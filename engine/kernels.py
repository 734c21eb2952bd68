"""Which variants of the compiled kernels scenes need, and how they are compiled beforehand.

A variant leaves out what a scene doesn't need. Compiling one takes some ten seconds, once on a
machine; variants can be compiled side by side, each in a process of its own.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from engine.errors import GhostballError
from engine.scene import Scene
from engine.simulate import MAX_EVENTS, check_request


@dataclass(frozen=True)
class Variants:
    """The variants that some scenes need of one kind of kernels; what one process compiles.

    Attributes
    ----------
    name : str
        Of the variant that a run of these scenes begins with.
    scenes : tuple of Scene
    tangents : bool
        Whether they are the kernels of the tangent map, not those of shots.
    """

    name: str
    scenes: tuple[Scene, ...]
    tangents: bool = False

    @property
    def is_compiled(self) -> bool:
        """Whether the variant that these scenes begin with is in the cache."""
        from engine._jit import compiled  # noqa: PLC0415 - it loads the compiler

        return compiled(self.name)

    def compile(self) -> None:
        """Compile what these scenes need, or load it where it is in the cache.

        A run begins with kernels that know no joint impact and no sustained contact. Those that do
        take twice as long to compile, so each scene is played to see whether it comes to need them.
        """
        if self.tangents:
            from engine import sensitivity  # noqa: PLC0415

            sensitivity.warm_up(self.scenes[0])
            return
        from engine import _run  # noqa: PLC0415

        _run.warm_up(_run.variant_of(self.scenes[0], contacts=False))
        meeting = (scene for scene in self.scenes if len(scene.balls) > 1)
        if any(_run.comes_to_contacts(scene) for scene in meeting):
            _run.warm_up(_run.variant_of(self.scenes[0], contacts=True))


def variants_of(scenes: Iterable[Scene], *, tangents: bool = False) -> list[Variants]:
    """Return what `scenes` need of the kernels; each entry can be compiled in a process of its own.

    Parameters
    ----------
    scenes : iterable of Scene
        One that this engine can't play needs nothing.
    tangents : bool
        Whether the kernels of the tangent map are needed too (`Result.sensitivity`).
    """
    from engine import _run, sensitivity  # noqa: PLC0415

    shots: dict[str, list[Scene]] = {}
    maps: dict[str, list[Scene]] = {}
    for scene in scenes:
        try:
            check_request(scene, "rest", MAX_EVENTS)
        except GhostballError:
            continue
        shots.setdefault(_run.variant_of(scene, contacts=False).name("shots"), []).append(scene)
        if tangents:
            maps.setdefault(sensitivity.variant_name(scene), []).append(scene)
    return [
        *(Variants(name, tuple(those)) for name, those in shots.items()),
        *(Variants(name, tuple(those), tangents=True) for name, those in maps.items()),
    ]


def warm_up(scenes: Iterable[Scene] = ()) -> None:
    """Compile or load the kernels that `scenes` need now, rather than in the first `simulate`.

    A compilation is announced. Before several processes are started, this keeps each of them from
    compiling for itself. Without scenes: what a shot of one ball needs.
    """
    from engine import _run  # noqa: PLC0415

    scenes = tuple(scenes) or (_run.still_scene(_run.Variant(False, False, False)),)
    for variants in variants_of(scenes):
        variants.compile()
