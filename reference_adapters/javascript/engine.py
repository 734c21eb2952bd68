"""Engines in JavaScript: each a class that says what it represents; node plays its scenes.

A process of node serves all shots of one engine and configuration, and ends with ours. What the
cloth does between the engine's steps, and where steps end with `contact_steps="exact"`, is the same
as in `stepping/`, written again in `driver/`: a process that were asked step by step would measure
its pipe. `config="naive"` is what a newcomer types: frames of 1/60 s, friction and damping as the
engine has them, restitution as the scene says.
"""

from __future__ import annotations

import atexit
import math
import shutil
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from ghostball.model import Record, Result, Scene, Status
from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.javascript.packages import DRIVER, NODE, folder, why_not
from ghostball.reference_adapters.stepping.ending import ending_of
from ghostball.reference_adapters.stepping.ends import ExactSteps
from ghostball.reference_adapters.stepping.plane_engine import PlaneEngine
from ghostball.reference_adapters.stepping.settings import SteppingSettings
from ghostball.reference_adapters.stepping.sides import reach_beyond
from ghostball.reference_adapters.workers.engine import run_of
from ghostball.reference_adapters.workers.process import Worker


class JavascriptSettings(SteppingSettings):
    """Settings of the engines in JavaScript.

    `dt` is 1e-3 s tuned, 1/60 s naive, 0.02 s in exact steps.
    """

    EXACT_IF_NAIVE: ClassVar[bool] = False
    CLOTH_BETWEEN_STEPS: ClassVar[bool] = False

    @property
    def kernels(self) -> tuple[str, ...]:
        """None of ours: node runs what the adapter adds."""
        return ()


class PlanckSettings(JavascriptSettings):
    """Settings of planck.js; `iterations` are of velocities, 8, its own.

    `bullet`: whether balls are bullets: contacts between them are found in continuous time. Where
        steps end at contacts, and in the naive configuration, they never are.
    """

    bullet: bool = True

    @property
    def bullets(self) -> bool:
        """Whether balls are bullets, with these settings."""
        return self.bullet and self.contact_steps == "fixed" and self.config == "tuned"


class MatterSettings(JavascriptSettings):
    """Settings of matter.js; `iterations` are of velocities, 4, its own.

    `sides`: of the polygon that stands for a ball, an even number; the naive configuration has
        what `Bodies.circle` makes.
    """

    sides: Annotated[int, Field(ge=8, le=10_000, multiple_of=2)] = 240


@cache
def _worker(name: str, config: str, packages: Path, node: str) -> Worker:
    worker = Worker([node, str(DRIVER / "serve.mjs"), str(packages), name, config])
    atexit.register(worker.close)
    return worker


LONGEST = 600.0
"""Time after which node is given up [s]; callers have limits of their own."""


class JavascriptEngine(PlaneEngine):
    """An engine whose driver is `driver/NAME.mjs`; `PACKAGE` is its package."""

    Settings: ClassVar[type[EngineSettings]] = JavascriptSettings

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Have node play the scene: to rest, to `t_max`, or to `max_time` or `max_steps`.

        Raises `UnsupportedSceneError` where the scene needs a feature that these settings lack.
        """
        self.check(scene)
        settings: JavascriptSettings = self.settings
        ends = self.EXACT_STEPS
        asked = settings.model_dump() | {
            "dt": self.step(scene),
            "gap": ends.gap,
            "shortest": ends.shortest,
            "reach": reach_beyond(scene),
        }
        worker = _worker(self.name, settings.config, folder(), shutil.which(NODE) or NODE)
        run = run_of(self.name, worker, scene, record, LONGEST, asked)
        used: dict[str, Any] = {"dt": settings.step, "iterations": run.settings.get("iterations")}
        run = run.model_copy(update={"settings": settings.model_dump() | used})
        result = run.result(scene, record=record)
        if result.status is not Status.STEP_LIMIT:
            return result
        _, reason = ending_of(scene, settings, result.rest_time, result.final_state, at_rest=False)
        return replace(result, reason=reason)

    @classmethod
    def unavailable(cls) -> str | None:
        """Return how to get node or the engine's package where they aren't there, or None."""
        return why_not(cls.PACKAGE)


class PlanckEngine(JavascriptEngine):
    """planck.js: Box2D 2.3 in JavaScript, in double precision."""

    name: ClassVar[str] = "planck"
    PACKAGE: ClassVar[str] = "planck"
    Settings: ClassVar[type[EngineSettings]] = PlanckSettings
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "planck")
    BULLET: ClassVar[float] = 3e-7
    """How far bullets overlap where they meet [m]: three of its slops."""

    def resolution(self, scene: Scene) -> float:
        """Return how far a ball goes in a step [m]; or how far bullets overlap.

        These meet where they touch, but with the mean velocities of the step: where the cloth
        slows balls, that is as of a step.
        """
        settings: PlanckSettings = self.settings
        slowed = bool(np.any(scene.rolling_frictions)) or scene.physics.motion == "sliding"
        return self.BULLET if settings.bullets and not slowed else super().resolution(scene)


class MatterEngine(JavascriptEngine):
    """matter.js: polygons in a plane, in pixels and milliseconds."""

    name: ClassVar[str] = "matter-js"
    PACKAGE: ClassVar[str] = "matter-js"
    Settings: ClassVar[type[EngineSettings]] = MatterSettings
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "matter-js")
    EXACT_STEPS: ClassVar[ExactSteps] = ExactSteps(gap=1e-6)

    def resolution(self, scene: Scene) -> float:
        """Return how far a ball goes in a step [m], or a polygon's side lies inside of its ball."""
        settings: MatterSettings = self.settings
        sides = settings.sides if settings.config == "tuned" else 25
        inside = float(scene.radii.max()) * (1.0 - math.cos(math.pi / sides))
        return super().resolution(scene) + inside


class CannonEngine(JavascriptEngine):
    """cannon-es: spheres in space, in the plane of the table."""

    name: ClassVar[str] = "cannon-es"
    PACKAGE: ClassVar[str] = "cannon-es"
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "cannon-es")
