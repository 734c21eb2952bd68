"""What engines share whose balls move in the plane with the cloth applied between their steps."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from pkgutil import resolve_name
from typing import Any, ClassVar

from ghostball.model import Record, Result, Scene
from ghostball.model.features import Capabilities
from ghostball.reference_adapters.base import EngineBase, lacking_sequence, resolution_of_step
from ghostball.reference_adapters.capabilities import ByConfiguration
from ghostball.reference_adapters.stepping.ending import end_of
from ghostball.reference_adapters.stepping.ends import Clock, Ends, ExactSteps, StepsToContacts
from ghostball.reference_adapters.stepping.plane import ClosedForm, PlaneWorld, Stepper, run


class PlaneEngine(EngineBase):
    """An engine that a `PlaneWorld` stands for, with `SteppingSettings`.

    Only the module of its world imports the engine itself, so that a list of engines doesn't; see
    `world_class`.
    """

    CAPABILITIES: ClassVar[ByConfiguration]
    """What it represents, by `config`."""
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
        represented: Capabilities = self.CAPABILITIES[self.settings.config]
        return represented

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
        world: PlaneWorld = self.world_class()(scene, self.settings)
        return world

    @classmethod
    def world_class(cls) -> Any:
        """Return the class of its world; an adapter that lies elsewhere imports its own here.

        By default `World` in the module `world` of the engine's folder in `reference_adapters`.
        """
        return resolve_name(f"ghostball.reference_adapters.{cls.name}.world:World")

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
        return ClosedForm(scene, world, ends)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Run to rest, to `t_max`, or to `max_time` or `max_steps`.

        Raises `UnsupportedSceneError` where the scene needs a feature that these settings lack.
        """
        self.check(scene)
        world = self.world(scene)
        return run(scene, record, self.name, self.settings, world, self.stepper(scene, world))
