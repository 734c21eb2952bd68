"""Base class of engines whose balls move in the plane, with the cloth applied between steps."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from pkgutil import resolve_name
from typing import Any, ClassVar

from ghostball.model import Record, Result, Scene
from ghostball.model.features import Capabilities
from ghostball.reference_adapters.base import EngineBase, lacking_sequence, resolution_of_step
from ghostball.reference_adapters.capabilities import ByConfiguration
from ghostball.reference_adapters.stepping.closed_form import ClosedFormStepper
from ghostball.reference_adapters.stepping.plane import PlaneWorld, WorldStepper
from ghostball.reference_adapters.stepping.run_end import end_of, run
from ghostball.reference_adapters.stepping.step_ends import (
    Clock,
    ExactSteps,
    StepEnds,
    StepsToContacts,
)


class PlaneEngine(EngineBase):
    """An engine with a `PlaneWorld` and `SteppingSettings`.

    Only the module of the world imports the external engine, so that listing engines doesn't; see
    `world_class`.
    """

    CAPABILITIES: ClassVar[ByConfiguration]
    """Capabilities, by `config`."""
    EXACT_STEPS: ClassVar[ExactSteps] = ExactSteps()
    PACKAGE: ClassVar[str]
    """Imported package; the extra that installs it has the engine's name."""

    WORLD: ClassVar[str] = ""
    """Name of the class of the world; see `world_class`."""

    @classmethod
    def unavailable(cls) -> str | None:
        """Return how to install the engine if it is missing, or None."""
        if importlib.util.find_spec(cls.PACKAGE) is not None:
            return None
        return (
            "optional engine, not installed. Run "
            f"`python -m pip install '.[{cls.name}]'` in a clone of Ghostball, or `.[engines]` for "
            "all optional engines"
        )

    @property
    def capabilities(self) -> Capabilities:
        """How each feature of a scene is supported with these settings."""
        represented: Capabilities = self.CAPABILITIES[self.settings.capability_name]
        return represented

    def _lacking(self, scene: Scene) -> Iterator[str]:
        yield from lacking_sequence(scene)

    def resolution(self, scene: Scene) -> float:
        """Return the distance that a ball moves in a step [m], or the gap at which steps end."""
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
        """Return the class of the world; an adapter outside this package imports its own here.

        By default, the class `WORLD` in the module `world` of the engine's folder in
        `reference_adapters`.
        """
        return resolve_name(f"ghostball.reference_adapters.{cls.name}.world:{cls.WORLD}")

    def step(self, scene: Scene) -> float:  # noqa: ARG002
        """Return the time step for a scene [s]; the longest step if steps end at contacts."""
        step: float = self.settings.step
        return step

    def stepper(self, scene: Scene, world: Any) -> WorldStepper:
        """Return the stepper of a world; its steps end at the end of the run."""
        dt, t_end = self.step(scene), end_of(scene, self.settings)
        ends: StepEnds = Clock(dt, t_end)
        if self.settings.contact_steps == "exact":
            ends = StepsToContacts(scene, self.EXACT_STEPS, dt, t_end)
        return ClosedFormStepper(scene, world, ends)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Run until all balls rest, to `t_max`, or to `max_time` or `max_steps`.

        Raises `UnsupportedSceneError` if the scene needs a feature that these settings lack.
        """
        self.check(scene)
        world = self.world(scene)
        return run(scene, record, self.name, self.settings, world, self.stepper(scene, world))
