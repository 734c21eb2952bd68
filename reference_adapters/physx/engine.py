"""PhysX 5 on the processor, through SAPIEN: a 3D engine in single precision.

Its solver is one of two, projected Gauss-Seidel or, as SAPIEN has it, temporal Gauss-Seidel, which
changes the energy of every impact. `contact_steps="fixed"` sees contacts when balls overlap as a
step begins; `contact_steps="exact"` ends the steps where balls touch. `cloth="own"` has balls slide
on a plane under gravity, with PhysX's friction; else the adapter applies the cloth between the
steps. `config="naive"` is SAPIEN's: impacts slower than 2 m/s are inelastic, contacts begin 1 cm
apart.
"""

from __future__ import annotations

from typing import ClassVar, Literal

from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.stepping.ends import IN_SINGLE_PRECISION, ExactSteps
from ghostball.reference_adapters.stepping.settings import OwnClothSettings
from ghostball.reference_adapters.stepping.space import OwnClothEngine

TUNED_ITERATIONS = 64
"""Position iterations of the tuned projected solver.

With 10, a frozen break gains 1.2e-4 of its energy; with 20 or more, nothing.
"""


class PhysxSettings(OwnClothSettings):
    """Settings of the PhysX adapter.

    `dt` is 1e-3 s tuned, SAPIEN's own 0.01 s naive, 0.02 s in exact steps.

    `iterations`: position iterations; 64 for the tuned projected solver, otherwise SAPIEN's 10.
    `solver`: projected or temporal Gauss-Seidel; None is "pgs" tuned, SAPIEN's own "tgs" naive.
    """

    NAIVE_DT: ClassVar[float] = 0.01
    EXACT_IF_NAIVE: ClassVar[bool] = False

    solver: Literal["pgs", "tgs"] | None = None

    @property
    def temporal(self) -> bool:
        """Whether the solver is the temporal one."""
        return (self.solver or ("pgs" if self.config == "tuned" else "tgs")) == "tgs"


class PhysxEngine(OwnClothEngine):
    """PhysX behind the protocol; see the module."""

    name: ClassVar[str] = "physx"
    PACKAGE: ClassVar[str] = "sapien"
    Settings: ClassVar[type[EngineSettings]] = PhysxSettings
    TITLE: ClassVar[str] = "PhysX"
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "physx")
    EXACT_STEPS: ClassVar[ExactSteps] = IN_SINGLE_PRECISION
