"""What engines share whose balls move in the plane with the cloth applied between their steps."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from pkgutil import resolve_name
from typing import Any, ClassVar

from ghostball.model import Record, Result, Scene
from ghostball.model.features import EXACT, Capabilities, Capability, Feature
from ghostball.reference_adapters.base import (
    EngineBase,
    lacking_sequence,
    none,
    resolution_of_step,
)
from ghostball.reference_adapters.stepping.ending import end_of
from ghostball.reference_adapters.stepping.ends import Clock, Ends, ExactSteps, StepsToContacts
from ghostball.reference_adapters.stepping.plane import ClosedForm, PlaneWorld, Stepper, run


class PlaneEngine(EngineBase):
    """An engine that a `PlaneWorld` stands for, with `SteppingSettings`."""

    WORLD: ClassVar[str]
    """Its `PlaneWorld`, "MODULE:CLASS", which imports the engine: so a list of engines doesn't."""
    TUNED: ClassVar[Capabilities]
    NAIVE: ClassVar[Capabilities]
    EXACT_STEPS: ClassVar[ExactSteps] = ExactSteps()
    PACKAGE: ClassVar[str]
    """What is imported; the extra that brings it has the engine's name."""

    @classmethod
    def unavailable(cls) -> str | None:
        """Return how to get the engine where it isn't installed, or None."""
        if importlib.util.find_spec(cls.PACKAGE) is not None:
            return None
        return (
            "it is optional, and not installed. Run "
            f"`python -m pip install '.[{cls.name}]'` in a clone of Ghostball, or `.[engines]` for "
            "all optional engines"
        )

    @property
    def capabilities(self) -> Capabilities:
        """How each feature of a scene is represented with these settings."""
        return self.TUNED if self.settings.config == "tuned" else self.NAIVE

    def _lacking(self, scene: Scene) -> Iterator[str]:
        yield from lacking_sequence(scene)

    def resolution(self, scene: Scene) -> float:
        """Return how far a ball goes in a step [m]; or how far from a contact its step ends."""
        if self.settings.contact_steps == "exact":
            gap, shortest = self.EXACT_STEPS
            return max(gap, resolution_of_step(shortest, scene))
        return resolution_of_step(self.settings.step, scene)

    def world(self, scene: Scene) -> PlaneWorld:
        """Load the engine, and build the scene in it."""
        world: PlaneWorld = resolve_name(self.WORLD)(scene, self.settings)
        return world

    def step(self, scene: Scene) -> float:  # noqa: ARG002
        """Return the step for a scene [s]; the longest, where steps end at contacts."""
        step: float = self.settings.step
        return step

    def stepper(self, scene: Scene, world: Any) -> Stepper:
        """Return what moves the balls of a world on, in steps that end when the run does."""
        dt, t_end = self.step(scene), end_of(scene, self.settings)
        ends: Ends = Clock(dt, t_end)
        if self.settings.contact_steps == "exact":
            ends = StepsToContacts(scene, self.EXACT_STEPS, dt, t_end)
        return self.in_plane(scene, world, ends)

    def in_plane(self, scene: Scene, world: Any, ends: Ends) -> Stepper:
        """Return what moves balls on in the plane, in steps that end as `ends` says."""
        return ClosedForm(scene, world, ends)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Run to rest, to `t_max`, or to `max_time` or `max_steps`.

        Raises `UnsupportedSceneError` where the scene needs a feature that these settings lack.
        """
        self.check(scene)
        world = self.world(scene)
        return run(scene, record, self.name, self.settings, world, self.stepper(scene, world))


def tuned_capabilities(
    title: str, impacts: Capability, rubs: Capability, parts: Capability
) -> Capabilities:
    """Return what an engine represents in the plane.

    `title`: the engine's name as its users write it.
    `impacts`, `rubs`: how it represents restitution, and friction at contacts.
    `parts`: how it represents parts of cushions, and discs.
    """
    between = Capability(
        "approximate", f"the adapter applies the cloth between {title}'s steps, in closed form"
    )
    flat = none(f"{title}'s cushion is a vertical plane: it has no nose above the ball's centre")
    return {
        Feature.ROLLING: EXACT,
        Feature.SLIDING: between,
        Feature.FRICTIONLESS_CLOTH: EXACT,
        Feature.VERTICAL_SPIN: between,
        Feature.BALL_RESTITUTION: impacts,
        Feature.BALL_FRICTION: rubs,
        Feature.SPEED_DEPENDENT_FRICTION: none(
            f"{title}'s friction is one number for two bodies, whatever their slip"
        ),
        Feature.MATHAVAN_BALL: none(
            "the cloth takes part in this impact, and the adapter applies it between the steps"
        ),
        Feature.UNEQUAL_MASSES: EXACT,
        Feature.UNEQUAL_RADII: EXACT,
        Feature.PER_BALL_FRICTION: EXACT,
        Feature.UNBOUNDED_CLOTH: EXACT,
        Feature.OPEN_SIDES: EXACT,
        Feature.POLYGON: parts,
        Feature.POCKETS: pocketed(parts),
        Feature.POSTS: parts,
        Feature.MIRROR_CUSHION: impacts,
        Feature.CUSHION_RESTITUTION: impacts,
        Feature.FALLING_RESTITUTION: none(f"{title}'s restitution is one number at any speed"),
        Feature.CUSHION_TANGENTIAL: Capability(
            "approximate",
            f"{title} has none: the adapter scales the velocity along the cushion after the step",
        ),
        Feature.FRICTIONAL_CUSHION: rubs,
        Feature.HAN_CUSHION: flat,
        Feature.MATHAVAN_CUSHION: flat,
        Feature.AIR_DRAG: none(f"{title} has no drag of k |v| v"),
        Feature.QUADRATIC_ROLLING: none("the cloth slows a ball by one force, whatever the speed"),
        Feature.FLIGHT: none("the adapter keeps the balls in the plane"),
    }


def pocketed(parts: Capability) -> Capability:
    """Return how pockets are represented, given how parts of cushions, and discs, are."""
    if parts.support == "none":
        return parts
    return Capability(
        parts.support,
        f"{parts.how}; the adapter takes a ball out where the way of its centre in a step enters "
        "the hole",
    )


def disc_capabilities(
    title: str, impacts: Capability, rubs: Capability, parts: Capability
) -> Capabilities:
    """Return what a 2D engine represents, whose friction is given its share of the slip."""
    flat = none(f"{title}'s plane has no height for the nose to touch a ball at")
    cloth = none(f"the cloth takes part in this impact, and {title}'s plane has none")
    return {
        **tuned_capabilities(title, impacts, rubs, parts),
        Feature.FALLING_RESTITUTION: Capability(
            "approximate",
            f"{title} asks for the restitution of each contact: it is given that of the speed with "
            "which the ball then comes",
        ),
        Feature.SPEED_DEPENDENT_FRICTION: rubs,
        Feature.MATHAVAN_BALL: cloth,
        Feature.MATHAVAN_CUSHION: cloth,
        Feature.HAN_CUSHION: flat,
        Feature.FLIGHT: none(f"{title} works in a plane"),
    }


def frictionless_capabilities(title: str, impacts: Capability, parts: Capability) -> Capabilities:
    """Return what an engine represents in the plane whose contacts are driven without friction."""
    flat = none(f"{title} is driven here without friction at contacts")
    tuned = tuned_capabilities(title, impacts, flat, parts)
    return {**tuned, Feature.SPEED_DEPENDENT_FRICTION: flat}


def naive_capabilities(tuned: Capabilities, title: str, impacts: Capability) -> Capabilities:
    """Return what an engine represents as a newcomer has it: without the adapter's own cloth."""
    cloth = none("the cloth of balls that slide is the adapter's own, of `config=tuned`")
    spin = none("balls that don't slide have no spin to rub with")
    return {
        **tuned,
        Feature.SLIDING: cloth,
        Feature.VERTICAL_SPIN: cloth,
        Feature.BALL_FRICTION: spin,
        Feature.SPEED_DEPENDENT_FRICTION: spin,
        Feature.FRICTIONAL_CUSHION: spin,
        Feature.BALL_RESTITUTION: impacts,
        Feature.MIRROR_CUSHION: impacts,
        Feature.CUSHION_RESTITUTION: impacts,
        Feature.FALLING_RESTITUTION: none(f"{title}'s restitution, set once, is one number"),
        Feature.CUSHION_TANGENTIAL: none(f"{title} has no such law; `config=tuned` adds one"),
    }
