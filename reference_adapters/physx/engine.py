"""PhysX 5 on the CPU, through SAPIEN: a 3D engine in single precision.

It has two solvers: projected Gauss-Seidel, and SAPIEN's default, temporal Gauss-Seidel, which
changes the energy of every impact. `contact_steps="fixed"` detects contacts when balls overlap at
the start of a step; `contact_steps="exact"` ends the steps when balls touch. `cloth="own"` lets
balls slide on a plane under gravity with PhysX's friction; otherwise the adapter applies cloth
friction between time steps. `config="naive"` has SAPIEN's defaults: impacts slower than 2 m/s are
inelastic, and contacts start at a gap of 1 cm.
"""

from __future__ import annotations

from typing import ClassVar, Literal

from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.stepping.settings import OwnClothSettings
from ghostball.reference_adapters.stepping.space import OwnClothEngine
from ghostball.reference_adapters.stepping.step_ends import SINGLE_PRECISION_STEPS, ExactSteps

TUNED_ITERATIONS = 64
"""Number of position iterations of the tuned projected solver.

With 10, a break of touching balls gains 1.2e-4 of its energy; with 20 or more, nothing.
"""


class PhysxSettings(OwnClothSettings):
    """Settings of the PhysX adapter.

    `dt`: 1e-3 s tuned; 0.01 s naive, SAPIEN's default; 0.02 s with exact steps.
    `iterations`: position iterations; 64 for the tuned projected solver, otherwise SAPIEN's 10.
    `solver`: projected ("pgs") or temporal ("tgs") Gauss-Seidel. None: "pgs" tuned; "tgs" naive,
        SAPIEN's default.
    """

    NAIVE_DT: ClassVar[float] = 0.01
    EXACT_IF_NAIVE: ClassVar[bool] = False

    solver: Literal["pgs", "tgs"] | None = None

    @property
    def temporal(self) -> bool:
        """Whether the temporal solver is used."""
        return (self.solver or ("pgs" if self.config == "tuned" else "tgs")) == "tgs"


class PhysxEngine(OwnClothEngine):
    """PhysX as a reference engine; see this module."""

    name: ClassVar[str] = "physx"
    PACKAGE: ClassVar[str] = "sapien"
    WORLD: ClassVar[str] = "PhysxWorld"
    Settings: ClassVar[type[EngineSettings]] = PhysxSettings
    TITLE: ClassVar[str] = "PhysX"
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "physx")
    EXACT_STEPS: ClassVar[ExactSteps] = SINGLE_PRECISION_STEPS
