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

from ghostball.model.features import Capabilities, Capability
from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.physx.settings import PhysxSettings
from ghostball.reference_adapters.stepping.ends import IN_SINGLE_PRECISION, ExactSteps
from ghostball.reference_adapters.stepping.plane_engine import (
    naive_capabilities,
    tuned_capabilities,
)
from ghostball.reference_adapters.stepping.space import OwnClothEngine

_IMPACTS = Capability(
    "approximate", "in single precision: impacts at 5 mm/s lose up to 8 % of their speed"
)
_RUBS = Capability(
    "approximate",
    "PhysX's own friction at the contact, a pyramid: along each of two directions it has the whole "
    "coefficient, so that slip along both gets up to 41 % too much; the adapter keeps the balls in "
    "the plane",
)
_PARTS = Capability(
    "approximate",
    "upright boxes 2 um thick, and spheres, in single precision",
)
_INELASTIC = Capability(
    "approximate",
    "impacts slower than 2 m/s are inelastic, and the temporal solver changes the energy of others",
)


class PhysxEngine(OwnClothEngine):
    """PhysX behind the protocol; see the module."""

    name: ClassVar[str] = "physx"
    WORLD: ClassVar[str] = "ghostball.reference_adapters.physx.world:World"
    PACKAGE: ClassVar[str] = "sapien"
    Settings: ClassVar[type[EngineSettings]] = PhysxSettings
    TITLE: ClassVar[str] = "PhysX"
    FLIES: ClassVar[Capability] = Capability(
        "approximate",
        "in space, on a cloth without cushions; a landing is seen up to a step late, and what "
        "falls at less than (1 + 1 / (1 - e)) g dt doesn't bounce: balls that lie on the table "
        "would tremble",
    )
    TUNED: ClassVar[Capabilities] = tuned_capabilities("PhysX", _IMPACTS, _RUBS, _PARTS)
    NAIVE: ClassVar[Capabilities] = naive_capabilities(TUNED, "PhysX", _INELASTIC)
    EXACT_STEPS: ClassVar[ExactSteps] = IN_SINGLE_PRECISION
