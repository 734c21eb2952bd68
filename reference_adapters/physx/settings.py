"""Settings of the PhysX adapter."""

from __future__ import annotations

from typing import ClassVar, Literal

from ghostball.reference_adapters.stepping.settings import OwnClothSettings


class PhysxSettings(OwnClothSettings):
    """Settings of the PhysX adapter.

    `dt` is 1e-3 s tuned, SAPIEN's own 0.01 s naive, 0.02 s in exact steps; `iterations` are of
    positions, 10 as SAPIEN's own.

    `solver`: projected or temporal Gauss-Seidel; None is "pgs" tuned, SAPIEN's own "tgs" naive.
    """

    NAIVE_DT: ClassVar[float] = 0.01
    EXACT_IF_NAIVE: ClassVar[bool] = False

    solver: Literal["pgs", "tgs"] | None = None

    @property
    def temporal(self) -> bool:
        """Whether the solver is the temporal one."""
        return (self.solver or ("pgs" if self.config == "tuned" else "tgs")) == "tgs"
