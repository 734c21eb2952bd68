"""Rapier: a 3D engine in single precision, which applies restitution to contacts that it predicts.

Its default prediction distance of 2 cm turns a half-ball cut by 1 to 5 degrees, and a smaller step
doesn't help; tuned it is 1e-5 units, so that contacts are seen when balls overlap. Then a break
gains a third of its energy, at any step, and with the prediction it loses some: so Rapier has a row
for single impacts, not for racks.
`config="naive"` is what a newcomer types: frames of 1/60 s, the prediction, the mean of two
restitutions.
"""

from __future__ import annotations

from typing import ClassVar

from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.stepping.ends import IN_SINGLE_PRECISION, ExactSteps
from ghostball.reference_adapters.stepping.plane_engine import PlaneEngine
from ghostball.reference_adapters.stepping.settings import SteppingSettings


class RapierSettings(SteppingSettings):
    """Settings of the Rapier adapter.

    `dt` is 1e-3 s tuned, Rapier's own 1/60 s naive, 0.02 s in exact steps; `iterations` is
    Rapier's own, 4.
    """

    EXACT_IF_NAIVE: ClassVar[bool] = False


class RapierEngine(PlaneEngine):
    """Rapier behind the protocol; see the module."""

    name: ClassVar[str] = "rapier"
    PACKAGE: ClassVar[str] = "rapier3d"
    Settings: ClassVar[type[EngineSettings]] = RapierSettings
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "rapier")
    EXACT_STEPS: ClassVar[ExactSteps] = IN_SINGLE_PRECISION
