"""Rapier: a 3D engine in single precision, which applies restitution to predicted contacts.

Its default prediction distance of 2 cm changes the angle of a half-ball cut by 1 to 5 degrees, at
any time step. Tuned, the distance is 1e-5 units, so contacts are detected when balls overlap. A
break then gains a third of its energy, at any time step (with the default distance it loses some).
Use Rapier's results for single impacts, not for racks.
`cloth="own"` lets balls slide on a plane under gravity with Rapier's friction; otherwise the
adapter applies cloth friction between time steps.
`config="naive"` is what a newcomer types: time steps of 1/60 s, the default prediction distance,
and the mean of two restitutions.
"""

from __future__ import annotations

from typing import ClassVar

from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.stepping.settings import OwnClothSettings
from ghostball.reference_adapters.stepping.space import OwnClothEngine
from ghostball.reference_adapters.stepping.step_ends import SINGLE_PRECISION_STEPS, ExactSteps


class RapierSettings(OwnClothSettings):
    """Settings of the Rapier adapter.

    `dt`: 1e-3 s tuned; 1/60 s naive, Rapier's default; 0.02 s with exact steps.
    `iterations`: 4, Rapier's default.
    """

    EXACT_IF_NAIVE: ClassVar[bool] = False


class RapierEngine(OwnClothEngine):
    """Rapier as a reference engine; see this module."""

    name: ClassVar[str] = "rapier"
    PACKAGE: ClassVar[str] = "rapier3d"
    WORLD: ClassVar[str] = "RapierWorld"
    TITLE: ClassVar[str] = "Rapier"
    Settings: ClassVar[type[EngineSettings]] = RapierSettings
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "rapier")
    EXACT_STEPS: ClassVar[ExactSteps] = SINGLE_PRECISION_STEPS
