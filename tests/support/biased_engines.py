"""Engines that break one relation each: Ghostball's motion with an unphysical displacement."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ghostball.engine import simulate
from ghostball.model import Record, Result, Samples, Scene, UnsupportedSceneError
from ghostball.model.arrays import FloatArray
from ghostball.model.features import EXACT, Capabilities, Feature
from ghostball.reference_adapters import EngineBase, EngineSettings

Rule = Callable[[Scene, FloatArray, FloatArray], FloatArray]
"""Displacement (m, n, 3) [m] for a scene, times (m, 1, 1) [s] and ways since the start (m, n, 3).

A ball at rest stays where it is.
"""


def _wind(scene: Scene, t: FloatArray, way: FloatArray) -> FloatArray:
    along: FloatArray = 1e-5 * np.abs(way[..., [0, 0, 0]]) * np.array([1.0, 0.0, 0.0])
    return along


def _swirl(scene: Scene, t: FloatArray, way: FloatArray) -> FloatArray:
    aside: FloatArray = 1e-5 * np.cross([0.0, 0.0, 1.0], way)
    return aside


RULES: Mapping[str, Rule] = {
    # Every ball is displaced towards +x.
    "rotate": _wind,
    # A ball goes farther if it starts at a large x.
    "translate": lambda scene, t, way: 1e-5 * way * np.abs(scene.positions[:, :1]),
    # Every ball is displaced to the left of its way.
    "mirror": _swirl,
    # The first ball goes farther than the others.
    "renumber": lambda scene, t, way: 1e-5 * way * (np.arange(way.shape[1]) == 0)[:, np.newaxis],
    # Ways are multiples of 0.7 um.
    "scale": lambda scene, t, way: 7e-7 * np.round(way / 7e-7) - way,
    # All balls go farther if one of them starts fast.
    "boost": lambda scene, t, way: 1e-5 * way * np.max(np.abs(scene.velocities)),
    # The displacement depends on the time, not only on the state of the balls.
    "split": lambda scene, t, way: 1e-4 * way * t,
    # A ball goes farther if there are more balls.
    "far-ball": lambda scene, t, way: 1e-5 * way * way.shape[1],
    # No rule.
    "none": lambda scene, t, way: 0.0 * way,
}
"""The displacement that breaks a relation, by the relation."""


@dataclass(frozen=True)
class _Displaced:
    """A trajectory with displaced positions."""

    result: Result
    rule: Rule

    @property
    def t_end(self) -> float:
        return self.result.rest_time

    def sample(self, times: ArrayLike) -> Samples:
        t = np.atleast_1d(np.asarray(times, dtype=np.float64))
        found, scene = self.result.sample(t), self.result.scene
        way = found.positions - scene.positions
        moved = self.rule(scene, t[:, np.newaxis, np.newaxis], way)
        return found._replace(positions=found.positions + moved)


class BiasedSettings(EngineSettings):
    """The relation that the engine breaks."""

    way: str = "none"


class Biased(EngineBase):
    """An engine that claims to be exact, and breaks one relation."""

    name: ClassVar[str] = "biased"
    Settings: ClassVar[type[EngineSettings]] = BiasedSettings
    capabilities: ClassVar[Capabilities] = dict.fromkeys(Feature, EXACT)

    def resolution(self, scene: Scene) -> float:
        return 0.0

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        self.check(scene)
        result = simulate(scene, record="trajectory")
        displaced = _Displaced(result, RULES[self.settings.way])
        return replace(
            result,
            engine=self.name,
            settings={},
            final_state=displaced.sample([result.rest_time]),
            events=None if record == "rest" else result.events,
            trajectory=displaced if record == "trajectory" else None,
        )


class Alone(Biased):
    """An engine that refuses more than two balls."""

    name: ClassVar[str] = "alone"

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        if len(scene.balls) > 2:
            raise UnsupportedSceneError(self.name, ("no more than two balls",))
        return super().simulate(scene, record=record)
