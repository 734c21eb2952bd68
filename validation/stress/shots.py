"""A generated shot: a scene, and what is asked of it besides the law.

>>> shot("head-on", scene, limit("collision_count", "They meet once.", equals=1), depth=0.5)
Shot(scene=..., criteria=..., stepped=True)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ghostball.model import GhostballError, Scene
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.checks.criterion import EVERY, Claim, Criterion
from ghostball.validation.truth.scene_truth import WantedTruth

LONGEST = 2.0
"""Simulated time [s] beyond which no engine with a time step is asked, unless a shot says so."""


class StressError(GhostballError, ValueError):
    """A family or a shot that doesn't exist."""


@dataclass(frozen=True)
class Size:
    """How many shots are generated.

    `full`: all of a family, not only what a CI has time for.
    `seed`, `count`: number of the first random shot, and how many there are; None: as many as the
        family has.
    """

    full: bool = False
    seed: int = 0
    count: int | None = None


@dataclass(frozen=True)
class Shot:
    """A scene, and what is asked of it.

    `criteria`: besides the law, and how much must be known of it without our engine.
    `stepped`: whether engines with a time step are asked: else it would take them too long.
    """

    scene: Scene
    criteria: Criteria
    stepped: bool


@dataclass(frozen=True)
class Family:
    """One question, asked over a range.

    `name`: as on the command line, such as "grazing".
    `title`: a few words, for tables.
    `asks`: what is asked of an engine, a sentence or two.
    `make`: yields the shots; those of the small size are among those of the full one, or are
        smaller ones of the same kind. Made anew at each call, always the same.
    """

    name: str
    title: str
    asks: str
    make: Callable[[Size], Iterable[Shot]]

    def shots(self, size: Size) -> Iterator[Shot]:
        """Yield the shots, each scene with the name of the family before its own."""
        for one in self.make(size):
            named = {
                "name": f"{self.name}.{one.scene.name}",
                "tags": ("stress", self.name, *one.scene.tags),
            }
            yield Shot(one.scene.model_copy(update=named), one.criteria, one.stepped)


def shot(
    name: str,
    scene: Scene,
    *limits: Criterion,
    truth: WantedTruth | None = None,
    proved: int | None = None,
    stepped: bool | None = None,
    **parameters: float,
) -> Shot:
    """Return a shot of this name.

    `truth`, `proved`: see `Criteria`.
    `stepped`: see `Shot`; left out: whether it is short.
    `parameters`: what the family varies, with the value here; they become tags such as "depth=0.1",
        by which the report says where an engine begins to fail.
    """
    tags = tuple(f"{key.replace('_', ' ')}={value:g}" for key, value in parameters.items())
    short = lasts(scene) <= LONGEST if stepped is None else stepped
    asked = Criteria(truth=truth, proved=proved, criteria=limits)
    return Shot(scene.model_copy(update={"name": name, "tags": tags}), asked, short)


def limit(metric: str, reason: str, *, claiming: Claim | None = None, **most: Any) -> Criterion:
    """Return a limit that holds for every engine, or for those that claim this."""
    given: dict[str, Any] = {"engines": (EVERY,), "metric": metric, "reason": reason}
    return Criterion(**given, claiming=claiming, if_measured=True, **most)


def lasts(scene: Scene) -> float:
    """Return about how long a shot lasts at most [s]: until friction has stopped its fastest ball.

    Twice that, since a lighter ball may be hit away faster.
    """
    slowing = float(np.min(scene.rolling_frictions)) * scene.physics.gravity
    surfaces = scene.radii * np.linalg.norm(scene.angular_velocities, axis=1)
    fastest = float(np.max(np.maximum(np.linalg.norm(scene.velocities, axis=1), surfaces)))
    until = 2.0 * fastest / slowing if slowing > 0.0 else math.inf
    return until if scene.t_max is None else min(until, scene.t_max)


def parameters_of(tags: Iterable[str]) -> dict[str, float]:
    """Return what a family varies, with the value in a shot, from the tags of its scene."""
    pairs = (tag.partition("=") for tag in tags)
    return {key: float(value) for key, equals, value in pairs if equals}


def power_of_ten(power: int) -> str:
    """Return a power of ten as names of shots have it: "1e-07", "1e04"."""
    return f"1e{power:+03d}".replace("+", "")


def size_of(value: float) -> str:
    """Return a number as names of shots have it: "0", "1e-07"."""
    return f"{value:.0e}".replace("+", "") if value else "0"
