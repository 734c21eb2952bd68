"""The interface of reference engines: name, capabilities, frozen settings, and `Scene` -> `Result`.

Your own engine joins through an entry point of the group `ghostball.engines` in your package:

    [project.entry-points."ghostball.engines"]
    my-engine = "my_package:MyEngine"

`MyEngine` is a class like those in this folder: `MyEngine(MyEngine.Settings(dt=1e-3))` creates an
engine, and `MyEngine.unavailable()` returns why it can't run here, or None.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import Any, ClassVar, Literal, Protocol, runtime_checkable

import numpy as np
from pydantic import BaseModel, ConfigDict

from ghostball.model import GhostballError, Record, Result, Scene, UnsupportedSceneError
from ghostball.model.features import Capabilities, missing_features

Resolution = float | Literal["proved"] | None
"""Largest position error of a ball at a collision, as declared by an engine [m].

0: only rounding causes errors. "proved": the position is certified. None: the engine declares
nothing, so its accuracy is unknown.
"""


class EngineError(GhostballError):
    """An unknown or unavailable engine, an invalid setting, or an invalid result or file."""


class EngineSettings(BaseModel):
    """Base class of engine settings: frozen; unknown or invalid settings are rejected."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


@runtime_checkable
class ReferenceEngine(Protocol):
    """One engine with its settings."""

    name: ClassVar[str]
    Settings: ClassVar[type[EngineSettings]]

    @property
    def capabilities(self) -> Capabilities:
        """How each feature of a scene is supported with these settings."""
        ...

    @property
    def settings(self) -> EngineSettings:
        """The settings, frozen."""
        ...

    @classmethod
    def unavailable(cls) -> str | None:
        """Return why the engine can't run here and how to install it, or None."""
        ...

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Simulate the scene.

        Raises
        ------
        UnsupportedSceneError
            If the scene needs a feature that the engine doesn't support.
        """
        ...


class EngineBase(ABC):
    """Base class of the engines of this package: stores the settings and checks the scene."""

    name: ClassVar[str]
    Settings: ClassVar[type[EngineSettings]] = EngineSettings

    def __init__(self, settings: EngineSettings | None = None) -> None:
        self._settings = self.Settings() if settings is None else settings

    @property
    def settings(self) -> Any:
        """The settings, frozen; an instance of `Settings`."""
        return self._settings

    @property
    @abstractmethod
    def capabilities(self) -> Capabilities:
        """How each feature of a scene is supported with these settings."""

    @abstractmethod
    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Simulate the scene; see `ReferenceEngine.simulate`."""

    @classmethod
    def unavailable(cls) -> str | None:
        """Return why the engine can't run here and how to install it, or None."""
        return None

    def resolution(self, scene: Scene) -> Resolution:  # noqa: ARG002
        """Return the largest position error of a ball at a collision [m]; None if unknown.

        The error of the physical model isn't included. The value determines the horizon of this
        engine and the limit on overlaps.
        """
        return None

    def lacks(self, scene: Scene) -> tuple[str, ...]:
        """Return a sentence for each unsupported property of `scene` that isn't a `Feature`."""
        return tuple(self._lacking(scene))

    def _lacking(self, scene: Scene) -> Iterator[str]:  # noqa: ARG002
        yield from ()

    def check(self, scene: Scene) -> None:
        """Raise `UnsupportedSceneError` if the engine doesn't support the scene."""
        lacks = (*missing_features(self.capabilities, scene), *self.lacks(scene))
        if lacks:
            raise UnsupportedSceneError(self.name, lacks)


def resolution_of(engine: ReferenceEngine, scene: Scene) -> Resolution:
    """Return an engine's `resolution`; None if it declares none."""
    states = getattr(engine, "resolution", None)
    stated: Resolution = None if states is None else states(scene)
    return stated


def stated_error(resolution: Resolution) -> float:
    """Return the declared position error of a ball [m]; 0 if it is certified, or unknown."""
    return 0.0 if resolution is None or resolution == "proved" else float(resolution)


def resolution_of_step(dt: float, scene: Scene) -> float:
    """Return the largest distance that a ball moves in one time step [m].

    A contact is detected up to this distance late.

    `dt`: time step [s].

    Friction acts at the lowest point of a ball, so m R x v + 2/5 m R^2 w about this point is
    conserved. A sliding ball therefore changes its velocity along a straight line, from v to the
    velocity of rolling, v - 2/7 u with the slip u. The larger of the two speeds is its maximum;
    for a ball that only spins, this is 2/7 R w. The higher speed of a lighter ball after an impact
    isn't counted.
    """
    v, w = scene.velocities, scene.angular_velocities
    rolled = v.copy()
    driven = ~scene.rolls & (scene.sliding_frictions > 0.0)
    slip = v[driven, :2] + scene.radii[driven, np.newaxis] * (w[driven][:, [1, 0]] * (-1.0, 1.0))
    rolled[driven, :2] -= 2.0 / 7.0 * slip
    fastest = float(np.max(np.linalg.norm([v, rolled], axis=2)))
    # A positive result even if the product underflows, because 0 means that only rounding causes
    # errors.
    return max(dt * fastest, math.ulp(0.0)) if np.any([v, rolled]) else 0.0


def lacking_sequence(scene: Scene) -> Iterator[str]:
    """Yield why a solver of all contacts of a time step can't simulate sequential impacts."""
    if scene.physics.impacts == "sequential" and len(scene.balls) > 1:
        yield (
            'no impacts = "sequential" (the solver resolves all contacts of a time step together)'
        )
