"""Newton on the processor: 3D rigid bodies as kernels of Warp, in single precision.

Two of its solvers have a restitution. Steel, a projected Gauss-Seidel solver, conserves momentum
and energy. XPBD corrects positions, and averages the changes of a body that touches several others:
momentum isn't conserved in such contacts, and a break gains several times its energy. Use XPBD's
results for single impacts, not for racks.
`contact_steps="fixed"` detects contacts when balls overlap at the start of a step;
`contact_steps="exact"` ends the steps when balls touch. `cloth="own"` lets balls slide on a plane
under gravity with Newton's friction; otherwise the adapter applies cloth friction between time
steps. `config="naive"` is what a newcomer types:
XPBD with the time step of Newton's examples, 1/600 s, and the mean of two restitutions.

Newton compiles its kernels at first use, for some two minutes, and stores them in Warp's cache.
"""

from __future__ import annotations

from typing import ClassVar, Literal

from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.stepping.settings import OwnClothSettings
from ghostball.reference_adapters.stepping.space import OwnClothEngine
from ghostball.reference_adapters.stepping.step_ends import SINGLE_PRECISION_STEPS, ExactSteps

TUNED_ITERATIONS = 64
"""Number of iterations of the tuned Steel solver; Newton's default is 12."""


class NewtonSettings(OwnClothSettings):
    """Settings of the Newton adapter.

    `dt`: 1e-3 s tuned; 1/600 s naive, as in Newton's examples; 0.02 s with exact steps.
    `iterations`: 64 for the tuned Steel solver; otherwise the default of Newton's solver, 12 for
        Steel and 2 for XPBD.
    `solver`: "steel" or "xpbd". None: "steel" tuned; "xpbd" naive.
    """

    NAIVE_DT: ClassVar[float] = 1.0 / 600.0
    EXACT_IF_NAIVE: ClassVar[bool] = False

    solver: Literal["steel", "xpbd"] | None = None

    @property
    def solver_used(self) -> Literal["steel", "xpbd"]:
        """The solver that is used: `solver`, or its default."""
        return self.solver or ("steel" if self.config == "tuned" else "xpbd")


class NewtonEngine(OwnClothEngine):
    """Newton as a reference engine; see this module."""

    name: ClassVar[str] = "newton"
    PACKAGE: ClassVar[str] = "newton"
    WORLD: ClassVar[str] = "NewtonWorld"
    Settings: ClassVar[type[EngineSettings]] = NewtonSettings
    TITLE: ClassVar[str] = "Newton"
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "newton")
    EXACT_STEPS: ClassVar[ExactSteps] = SINGLE_PRECISION_STEPS
