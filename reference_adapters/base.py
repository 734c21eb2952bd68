"""What a reference engine is: a name, capabilities, frozen settings, and `Scene` -> `Result`.

An engine of your own joins by an entry point of the group `ghostball.engines` in your package:

    [project.entry-points."ghostball.engines"]
    my-engine = "my_package:MyEngine"

where `MyEngine` is a class like the ones in this folder: `MyEngine(MyEngine.Settings(dt=1e-3))`
makes an engine, and `MyEngine.unavailable()` says why it can't run here, or None.
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
"""How far off a ball may be when it collides, as an engine states it [m].

0: by rounding alone. "proved": where it is, is proved. None: the engine states nothing, so nothing
is known of how exact it is.
"""


class EngineError(GhostballError):
    """An unknown engine, an unknown or wrong setting, or an engine that isn't installed."""


class EngineSettings(BaseModel):
    """Base of an engine's settings: frozen, and an unknown or wrong one is refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


@runtime_checkable
class ReferenceEngine(Protocol):
    """One engine with its settings."""

    name: ClassVar[str]
    Settings: ClassVar[type[EngineSettings]]

    @property
    def capabilities(self) -> Capabilities:
        """How each feature of a scene is represented with these settings."""
        ...

    @property
    def settings(self) -> EngineSettings:
        """The settings, frozen."""
        ...

    @classmethod
    def unavailable(cls) -> str | None:
        """Return why the engine can't run here and how to get it, or None."""
        ...

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Run the scene.

        Raises
        ------
        UnsupportedSceneError
            Where the scene needs a feature that the engine lacks.
        """
        ...


class EngineBase(ABC):
    """What the engines of this package share: they keep their settings and check the scene."""

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
        """How each feature of a scene is represented with these settings."""

    @abstractmethod
    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Run the scene; see `ReferenceEngine.simulate`."""

    @classmethod
    def unavailable(cls) -> str | None:
        """Return why the engine can't run here and how to get it, or None."""
        return None

    def resolution(self, scene: Scene) -> Resolution:  # noqa: ARG002
        """Return how far off a ball may be when it collides; None, what this returns, is unknown.

        Whatever the model. It says how soon chaos makes of this engine's shots others than the
        scene's, and to which limit overlaps are held.
        """
        return None

    def lacks(self, scene: Scene) -> tuple[str, ...]:
        """Return a sentence for each thing in `scene` that is no `Feature` and can't be done."""
        return tuple(self._lacking(scene))

    def _lacking(self, scene: Scene) -> Iterator[str]:  # noqa: ARG002
        yield from ()

    def check(self, scene: Scene) -> None:
        """Raise `UnsupportedSceneError` where the scene needs what the engine lacks."""
        lacks = (*missing_features(self.capabilities, scene), *self.lacks(scene))
        if lacks:
            raise UnsupportedSceneError(self.name, lacks)


def resolution_of(engine: ReferenceEngine, scene: Scene) -> Resolution:
    """Return an engine's `resolution`; None for an engine that states none."""
    states = getattr(engine, "resolution", None)
    stated: Resolution = None if states is None else states(scene)
    return stated


def stated_error(resolution: Resolution) -> float:
    """Return how far off a ball may be by what is stated [m]; 0 where it is proved, or unknown."""
    return 0.0 if resolution is None or resolution == "proved" else float(resolution)


def resolution_of_step(dt: float, scene: Scene) -> float:
    """Return how far a ball goes at most in a step [m] until balls meet: contacts come late.

    `dt` [s].

    Friction acts through the lowest point, about which m R x v + 2/5 m R^2 w is then kept; so a
    ball that slides goes straight from v to the v - 2/7 u with which it rolls, u its slip, and the
    faster of the two is the fastest it gets: with spin alone, 2/7 R w. What impacts give a lighter
    ball isn't counted.
    """
    v, w = scene.velocities, scene.angular_velocities
    rolled = v.copy()
    driven = ~scene.rolls & (scene.sliding_frictions > 0.0)
    slip = v[driven, :2] + scene.radii[driven, np.newaxis] * (w[driven][:, [1, 0]] * (-1.0, 1.0))
    rolled[driven, :2] -= 2.0 / 7.0 * slip
    fastest = float(np.max(np.linalg.norm([v, rolled], axis=2)))
    # A step is a step, also where the product is less than any double: 0 claims rounding alone.
    return max(dt * fastest, math.ulp(0.0)) if np.any([v, rolled]) else 0.0


def lacking_sequence(scene: Scene) -> Iterator[str]:
    """Yield what an engine lacks that solves all contacts of a step together."""
    if scene.physics.impacts == "sequential" and len(scene.balls) > 1:
        yield (
            'no impacts = "sequential" (its solver takes all contacts of a step together, never '
            "one after another)"
        )
