"""JavaScript engines: one class each with its supported features; Node.js runs the scenes.

One Node.js process runs all shots of an engine configuration and exits with Ghostball. The cloth
friction between steps, and the step ends for `contact_steps="exact"`, are those of `stepping/`,
implemented again in `driver/`: calling the process for every time step would measure the pipe
instead of the engine. `config="naive"` is what a newcomer types: time steps of 1/60 s, the engine's
default friction and damping, and the restitution of the scene.
"""

from __future__ import annotations

import math
import shutil
from dataclasses import replace
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from ghostball.model import Record, Result, Scene, Status
from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.javascript.packages import DRIVER, NODE, folder, why_unavailable
from ghostball.reference_adapters.recording import FRAME_INTERVAL
from ghostball.reference_adapters.stepping.plane_engine import PlaneEngine
from ghostball.reference_adapters.stepping.run_end import ending_of
from ghostball.reference_adapters.stepping.settings import SteppingSettings
from ghostball.reference_adapters.stepping.sides import reach_beyond
from ghostball.reference_adapters.stepping.step_ends import ExactSteps
from ghostball.reference_adapters.workers.engine import run_of, worker_of


class JavascriptSettings(SteppingSettings):
    """Settings of the JavaScript engines.

    `dt`: 1e-3 s tuned, 1/60 s naive, 0.02 s with exact steps.
    """

    EXACT_IF_NAIVE: ClassVar[bool] = False
    CLOTH_BETWEEN_STEPS: ClassVar[bool] = False

    @property
    def kernels(self) -> tuple[str, ...]:
        """None of Ghostball's kernels, because Node.js runs the adapter's code."""
        return ()


class PlanckSettings(JavascriptSettings):
    """Settings of planck.js; `iterations` are velocity iterations, 8 by default.

    `bullet`: whether balls are bullets, which detect contacts with each other in continuous time.
        With exact steps, and in the naive configuration, they never are.
    """

    bullet: bool = True

    @property
    def bullets(self) -> bool:
        """Whether balls are bullets with these settings."""
        return self.bullet and self.contact_steps == "fixed" and self.config == "tuned"


class MatterSettings(JavascriptSettings):
    """Settings of matter.js; `iterations` are velocity iterations, 4 by default.

    `sides`: number of sides of the polygon that represents a ball, even; in the naive
        configuration, it is that of `Bodies.circle`.
    """

    sides: Annotated[int, Field(ge=8, le=10_000, multiple_of=2)] = 240


class JavascriptEngine(PlaneEngine):
    """An engine whose driver is `driver/NAME.mjs`; `PACKAGE` is its package."""

    Settings: ClassVar[type[EngineSettings]] = JavascriptSettings

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Simulate the scene in Node.js to rest, to `t_max`, `max_time` or `max_steps`.

        Raises `UnsupportedSceneError` if the scene needs a feature that these settings lack.
        """
        self.check(scene)
        settings: JavascriptSettings = self.settings
        ends = self.EXACT_STEPS
        asked = settings.model_dump() | {
            "dt": self.step(scene),
            "gap": ends.gap,
            "shortest": ends.shortest,
            "reach": reach_beyond(scene),
            "frame_interval": FRAME_INTERVAL,
        }
        driver = str(DRIVER / "serve.mjs")
        command = (shutil.which(NODE) or NODE, driver, str(folder()), self.name, settings.config)
        run = run_of(self.name, worker_of(*command), scene, record, asked)
        used: dict[str, Any] = {"dt": settings.step, "iterations": run.settings.get("iterations")}
        run = run.model_copy(update={"settings": settings.model_dump() | used})
        result = run.result(scene, record=record)
        if result.status is not Status.STEP_LIMIT:
            return result
        _, reason = ending_of(scene, settings, result.rest_time, result.final_state, at_rest=False)
        return replace(result, reason=reason)

    @classmethod
    def unavailable(cls) -> str | None:
        """Return how to install Node.js or the engine's package if missing, or None."""
        return why_unavailable(cls.PACKAGE)


class PlanckEngine(JavascriptEngine):
    """planck.js: Box2D 2.3 in JavaScript, in double precision."""

    name: ClassVar[str] = "planck"
    PACKAGE: ClassVar[str] = "planck"
    Settings: ClassVar[type[EngineSettings]] = PlanckSettings
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "planck")
    BULLET_OVERLAP: ClassVar[float] = 3e-7
    """Overlap of bullets at a contact [m]: three slops."""

    def resolution(self, scene: Scene) -> float:
        """Return the distance that a ball moves in a step [m], or the overlap of bullets.

        Bullets meet when they touch, but with the mean velocities of the step, so with cloth
        friction the error is that of a step.
        """
        settings: PlanckSettings = self.settings
        slowed = bool(np.any(scene.rolling_frictions)) or scene.physics.motion == "sliding"
        return self.BULLET_OVERLAP if settings.bullets and not slowed else super().resolution(scene)


class MatterEngine(JavascriptEngine):
    """matter.js: polygons in a plane, in pixels and milliseconds."""

    name: ClassVar[str] = "matter-js"
    PACKAGE: ClassVar[str] = "matter-js"
    Settings: ClassVar[type[EngineSettings]] = MatterSettings
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "matter-js")
    EXACT_STEPS: ClassVar[ExactSteps] = ExactSteps(gap=1e-6)

    def resolution(self, scene: Scene) -> float:
        """Return the distance that a ball moves in a step, plus the error of its polygon [m]."""
        settings: MatterSettings = self.settings
        sides = settings.sides if settings.config == "tuned" else 25
        inside = float(scene.radii.max()) * (1.0 - math.cos(math.pi / sides))
        return super().resolution(scene) + inside


class CannonEngine(JavascriptEngine):
    """cannon-es: spheres in 3D, kept in the plane of the table."""

    name: ClassVar[str] = "cannon-es"
    PACKAGE: ClassVar[str] = "cannon-es"
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "cannon-es")
