"""MuJoCo: a 3D engine with fixed steps, whose contacts are soft by default.

`contact_steps="fixed"` sees contacts as MuJoCo does for its users, when balls overlap as a step
begins; `contact_steps="exact"` ends the steps where balls touch, so that only the solver's own
error remains. `config="tuned"` makes every contact a damper that ends it in one step, with the
restitution of the scene; `config="naive"` types what a newcomer types: there is no restitution,
and contacts are 20 ms long.
"""

from __future__ import annotations

from typing import ClassVar

from ghostball.model.features import Capabilities, Capability, Feature
from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.stepping.ends import ExactSteps
from ghostball.reference_adapters.stepping.plane_engine import (
    PlaneEngine,
    naive_capabilities,
    tuned_capabilities,
)
from ghostball.reference_adapters.stepping.settings import SteppingSettings


class MujocoSettings(SteppingSettings):
    """Settings of the MuJoCo adapter.

    `dt` is 1e-3 s tuned, MuJoCo's own 2e-3 s naive, 0.02 s in exact steps; `iterations` is 200
    tuned, MuJoCo's own 100 naive.
    """

    NAIVE_DT: ClassVar[float] = 2e-3
    EXACT_IF_NAIVE: ClassVar[bool] = False


_HARD = Capability(
    "approximate",
    "a damper reverses the approach in one step; MuJoCo caps how hard a contact may be, so that "
    "impulses of contacts that share a ball are 1e-4 off, and a single impact is exact",
)
_RUBS = Capability(
    "approximate",
    "MuJoCo's own friction at the contact, whose convex cone has slip part the bodies: impacts "
    "that stick are 7e-5 off, those that slip get too much of both impulses, 0.5 % with mu = 0.06 "
    "and 11 % with 0.2; the adapter keeps the balls in the plane",
)
_PARTS = Capability(
    "approximate",
    "capsules of 1 nm, whose ends are points, and spheres; at a corner that points into the table "
    "two of them share a ball",
)
_BETWEEN_STEPS = Capability(
    "approximate",
    "the adapter applies the cloth between MuJoCo's steps, in closed form: with MuJoCo's own "
    "rolling friction a ball that slides does not end where it should at any step",
)
_SOFT = Capability(
    "approximate",
    "MuJoCo has no restitution: its soft contacts, as nobody set them, take most of the speed",
)

_TUNED: Capabilities = {
    **tuned_capabilities("MuJoCo", _HARD, _RUBS, _PARTS),
    Feature.SLIDING: _BETWEEN_STEPS,
}


class MujocoEngine(PlaneEngine):
    """MuJoCo behind the protocol; see the module."""

    name: ClassVar[str] = "mujoco"
    WORLD: ClassVar[str] = "ghostball.reference_adapters.mujoco.world:World"
    PACKAGE: ClassVar[str] = "mujoco"
    Settings: ClassVar[type[EngineSettings]] = MujocoSettings
    TUNED: ClassVar[Capabilities] = _TUNED
    NAIVE: ClassVar[Capabilities] = naive_capabilities(_TUNED, "MuJoCo", _SOFT)
    EXACT_STEPS: ClassVar[ExactSteps] = ExactSteps(shortest=1e-7)
    """MuJoCo resolves a contact by an acceleration, and takes one above 1e10 m/s^2 for a failure.
    """
