"""MuJoCo: a 3D engine with fixed steps, whose contacts are soft by default.

`contact_steps="fixed"` sees contacts as MuJoCo does for its users, when balls overlap as a step
begins; `contact_steps="exact"` ends the steps where balls touch, so that only the solver's own
error remains. `config="tuned"` makes every contact a damper that ends it in one step, with the
restitution of the scene; `config="naive"` types what a newcomer types: there is no restitution,
and contacts are 20 ms long.
"""

from __future__ import annotations

from typing import ClassVar

from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.stepping.ends import ExactSteps
from ghostball.reference_adapters.stepping.plane_engine import PlaneEngine
from ghostball.reference_adapters.stepping.settings import SteppingSettings


class MujocoSettings(SteppingSettings):
    """Settings of the MuJoCo adapter.

    `dt` is 1e-3 s tuned, MuJoCo's own 2e-3 s naive, 0.02 s in exact steps; `iterations` is 200
    tuned, MuJoCo's own 100 naive.
    """

    NAIVE_DT: ClassVar[float] = 2e-3
    EXACT_IF_NAIVE: ClassVar[bool] = False


class MujocoEngine(PlaneEngine):
    """MuJoCo behind the protocol; see the module."""

    name: ClassVar[str] = "mujoco"
    PACKAGE: ClassVar[str] = "mujoco"
    Settings: ClassVar[type[EngineSettings]] = MujocoSettings
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "mujoco")
    EXACT_STEPS: ClassVar[ExactSteps] = ExactSteps(shortest=1e-7)
    """MuJoCo resolves a contact by an acceleration, and takes one above 1e10 m/s^2 for a failure.
    """
