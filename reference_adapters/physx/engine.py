"""PhysX 5 on the processor, through SAPIEN: a 3D engine in single precision.

Its solver is one of two, projected Gauss-Seidel or, as SAPIEN has it, temporal Gauss-Seidel, which
changes the energy of every impact. `contact_steps="fixed"` sees contacts when balls overlap as a
step begins; `contact_steps="exact"` ends the steps where balls touch. `cloth="own"` has balls slide
on a plane under gravity, with PhysX's friction; else the adapter applies the cloth between the
steps. `config="naive"` is SAPIEN's: impacts slower than 2 m/s are inelastic, contacts begin 1 cm
apart.
"""

from __future__ import annotations

from typing import ClassVar

from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.physx.settings import PhysxSettings
from ghostball.reference_adapters.stepping.ends import IN_SINGLE_PRECISION, ExactSteps
from ghostball.reference_adapters.stepping.space import OwnClothEngine


class PhysxEngine(OwnClothEngine):
    """PhysX behind the protocol; see the module."""

    name: ClassVar[str] = "physx"
    WORLD: ClassVar[str] = "ghostball.reference_adapters.physx.world:World"
    PACKAGE: ClassVar[str] = "sapien"
    Settings: ClassVar[type[EngineSettings]] = PhysxSettings
    TITLE: ClassVar[str] = "PhysX"
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "physx")
    EXACT_STEPS: ClassVar[ExactSteps] = IN_SINGLE_PRECISION
