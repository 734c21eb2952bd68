"""MuJoCo: a 3D engine with fixed time steps, whose contacts are soft by default.

`contact_steps="fixed"` uses MuJoCo's contact detection, overlap at the start of a step;
`contact_steps="exact"` ends the steps when balls touch, so that only the error of the solver
remains. `cloth="own"` lets balls lie on a plane under gravity, with MuJoCo's sliding, rolling and
torsional friction; otherwise the adapter applies cloth friction between time steps.
`config="tuned"` turns every contact into a damper that acts within one time step, with the
restitution of the scene; `config="naive"`, what a newcomer types, has no restitution and contacts
of 20 ms.
"""

from __future__ import annotations

from typing import Any, ClassVar

from ghostball.model import Scene
from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.stepping.plane import WorldStepper
from ghostball.reference_adapters.stepping.run_end import end_of
from ghostball.reference_adapters.stepping.settings import OwnClothSettings
from ghostball.reference_adapters.stepping.space import OwnClothEngine, OwnClothStepper
from ghostball.reference_adapters.stepping.step_ends import ExactSteps


class MujocoSettings(OwnClothSettings):
    """Settings of the MuJoCo adapter.

    `dt`: 1e-3 s tuned; 2e-3 s naive, MuJoCo's default; 0.02 s with exact steps.
    `iterations`: 200 tuned; 100 naive, MuJoCo's default.
    """

    NAIVE_DT: ClassVar[float] = 2e-3
    EXACT_IF_NAIVE: ClassVar[bool] = False


class MujocoEngine(OwnClothEngine):
    """MuJoCo as a reference engine; see this module."""

    name: ClassVar[str] = "mujoco"
    PACKAGE: ClassVar[str] = "mujoco"
    WORLD: ClassVar[str] = "MujocoWorld"
    Settings: ClassVar[type[EngineSettings]] = MujocoSettings
    TITLE: ClassVar[str] = "MuJoCo"
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "mujoco")
    EXACT_STEPS: ClassVar[ExactSteps] = ExactSteps(shortest=1e-7)
    """MuJoCo computes the acceleration of a contact, and fails above 1e10 m/s^2."""

    def on_cloth(self, scene: Scene, world: Any) -> WorldStepper:
        """Return the stepper of balls on MuJoCo's plane, which slows rolling and spins itself."""
        t_end = end_of(scene, self.settings)
        return OwnClothStepper(scene, world, self.step(scene), t_end, slows=False)
