"""Settings that engines which step in time share."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from ghostball.reference_adapters.base import EngineSettings


class SteppingSettings(EngineSettings):
    """Settings of an engine that steps in time.

    `contact_steps`: steps of `dt`, in which the engine sees contacts as it does for its users; or
        steps that end exactly where something touches, so that only the error of its solver
        remains.
    `config`: as experiments found best, or as a newcomer types it.
    `dt` [s]: the step; where steps end at contacts, the longest. None is what `step` says. A fixed
        step is shortened so that a whole number of them makes `t_max` (or `max_time`).
    `iterations`: of the contact solver; None is what the configuration says.
    `max_time` [s]: simulated time after which to give up.
    `max_steps`: steps after which to give up.
    """

    TUNED_DT: ClassVar[float] = 1e-3
    """Step of the tuned configuration [s]: a cut shot at 1 to 2 m/s rests about 1 cm off."""

    NAIVE_DT: ClassVar[float] = 1.0 / 60.0
    """Step of the naive configuration [s]: a frame."""

    EXACT_DT: ClassVar[float] = 0.02
    """Longest step where they end at contacts [s]: the paper's frame; any gives the same motion."""

    EXACT_IF_NAIVE: ClassVar[bool] = True
    """Whether steps can end at contacts in the naive configuration; not if contacts last longer."""

    CLOTH_BETWEEN_STEPS: ClassVar[bool] = True
    """Whether the adapter moves the balls between the engine's steps, with kernels of its own."""

    contact_steps: Literal["fixed", "exact"] = "fixed"
    config: Literal["tuned", "naive"] = "tuned"
    dt: Annotated[float, Field(ge=1e-9, le=1.0)] | None = None
    iterations: Annotated[int, Field(ge=1)] | None = None
    max_time: Annotated[float, Field(gt=0.0, le=1e6)] = 300.0
    max_steps: Annotated[int, Field(ge=1)] = 10_000_000

    @property
    def kernels(self) -> tuple[str, ...]:
        """The kernels that the adapter itself runs, by name; see `stepping.kernels`."""
        times = ("contact times",) if self.contact_steps == "exact" else ()
        return (*times, "cloth between steps") if self.CLOTH_BETWEEN_STEPS else times

    @model_validator(mode="after")
    def _contacts_end_within_a_step(self) -> Self:
        if (self.contact_steps, self.config) == ("exact", "naive") and not self.EXACT_IF_NAIVE:
            raise ValueError(
                "`contact_steps` = exact needs `config` = tuned: with default settings a contact "
                "lasts for many time steps. Change one of the two"
            )
        return self

    @property
    def step(self) -> float:
        """The step that `dt` stands for [s]."""
        if self.dt is not None:
            return self.dt
        if self.contact_steps == "exact":
            return self.EXACT_DT
        return self.TUNED_DT if self.config == "tuned" else self.NAIVE_DT


class OwnClothSettings(SteppingSettings):
    """Settings of an engine in space that may have a cloth of its own.

    `cloth`: where balls slide: the adapter applies the cloth between the steps; or they lie on a
    plane under gravity, and the engine's friction slows them.
    """

    cloth: Literal["closed-form", "own"] = "closed-form"

    @model_validator(mode="after")
    def _own_cloth_is_native(self) -> Self:
        if self.cloth == "own" and (self.contact_steps, self.config) != ("fixed", "tuned"):
            raise ValueError(
                "`cloth` = own needs `contact_steps` = fixed and `config` = tuned: a plane under "
                "gravity needs equal time steps. Change one of the two"
            )
        return self
