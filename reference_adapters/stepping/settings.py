"""Settings shared by time-stepping engines."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from ghostball.reference_adapters.base import EngineSettings


class SteppingSettings(EngineSettings):
    """Settings of a time-stepping engine.

    `contact_steps`: steps of `dt`, in which the engine detects contacts as for its users; or steps
        that end exactly at contacts, so that only the error of the solver remains.
    `config`: the best settings found in experiments, or the settings that a newcomer types.
    `dt`: the time step; the longest step if steps end at contacts [s]. For None, see `step`. A
        fixed step is shortened so that `t_max` (or `max_time`) is a whole number of steps.
    `iterations`: number of iterations of the contact solver; None is the value of the
        configuration.
    `max_time`: simulated time after which the run stops [s].
    `max_steps`: number of steps after which the run stops.
    """

    TUNED_DT: ClassVar[float] = 1e-3
    """Time step of the tuned configuration [s]; cut shots at 1 to 2 m/s have errors of 1 cm."""

    NAIVE_DT: ClassVar[float] = 1.0 / 60.0
    """Time step of the naive configuration [s]: one frame of a display."""

    EXACT_DT: ClassVar[float] = 0.02
    """Longest step if steps end at contacts [s], the paper's frame; it doesn't affect results."""

    EXACT_IF_NAIVE: ClassVar[bool] = True
    """Whether steps can end at contacts in the naive configuration; False if contacts last."""

    CLOTH_BETWEEN_STEPS: ClassVar[bool] = True
    """Whether the adapter applies the cloth between the engine's steps, with its own kernels."""

    contact_steps: Literal["fixed", "exact"] = "fixed"
    config: Literal["tuned", "naive"] = "tuned"
    dt: Annotated[float, Field(ge=1e-9, le=1.0)] | None = None
    iterations: Annotated[int, Field(ge=1)] | None = None
    max_time: Annotated[float, Field(gt=0.0, le=1e6)] = 300.0
    max_steps: Annotated[int, Field(ge=1)] = 10_000_000

    @property
    def kernels(self) -> tuple[str, ...]:
        """Names of the kernels that the adapter runs; see `stepping.kernels`."""
        times = ("contact times",) if self.contact_steps == "exact" else ()
        return (*times, "cloth between steps") if self.CLOTH_BETWEEN_STEPS else times

    @property
    def capability_name(self) -> str:
        """Name of the configuration in `capabilities.toml`."""
        return self.config

    @model_validator(mode="after")
    def _contacts_end_within_a_step(self) -> Self:
        if (self.contact_steps, self.config) == ("exact", "naive") and not self.EXACT_IF_NAIVE:
            raise ValueError(
                "`contact_steps` = exact needs `config` = tuned, because with default settings a "
                "contact lasts for many time steps. Change one of them"
            )
        return self

    @property
    def step(self) -> float:
        """The time step that is used [s]: `dt`, or its default."""
        if self.dt is not None:
            return self.dt
        if self.contact_steps == "exact":
            return self.EXACT_DT
        return self.TUNED_DT if self.config == "tuned" else self.NAIVE_DT


class OwnClothSettings(SteppingSettings):
    """Settings of an engine that may use its own cloth.

    `cloth`: the adapter applies the cloth friction between the steps ("closed-form"), or the engine
        has a cloth ("own"). In a 3D engine, balls that slide then lie on a plane under gravity,
        with the engine's friction.
    """

    cloth: Literal["closed-form", "own"] = "closed-form"

    @property
    def capability_name(self) -> str:
        """Name of the configuration in `capabilities.toml`."""
        return "own-cloth" if self.cloth == "own" else super().capability_name

    @model_validator(mode="after")
    def _own_cloth_is_native(self) -> Self:
        if self.cloth == "own" and (self.contact_steps, self.config) != ("fixed", "tuned"):
            raise ValueError(
                "`cloth` = own needs `contact_steps` = fixed and `config` = tuned, because the "
                "friction of an engine needs equal time steps. Change one of them"
            )
        return self
