"""A generated shot: a scene with limits in addition to the limits for every engine.

>>> shot("head-on", scene, limit("collision_count", "They meet once.", equals=1), depth=0.5)
StressShot(scene=..., criteria=..., stepped=True)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ghostball.model import Ball, GhostballError, Physics, Scene, Table
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.checks.criterion import EVERY, Claim, Criterion
from ghostball.validation.truth.scene_truth import WantedTruth

LONGEST = 2.0
"""Longest simulated time for time-stepping engines [s], unless a shot sets `stepped`."""


class StressError(GhostballError, ValueError):
    """A family or a shot that doesn't exist."""


@dataclass(frozen=True)
class StressSize:
    """Number of shots to generate.

    `full`: all shots of a family, not only those that a CI has time for.
    `seed`, `count`: number of the first random shot, and number of random shots; None: the
        family's own number.
    """

    full: bool = False
    seed: int = 0
    count: int | None = None


@dataclass(frozen=True)
class StressShot:
    """A scene and its limits.

    `criteria`: limits in addition to those for every engine, and the independent reference needed.
    `stepped`: True if time-stepping engines simulate the shot; False if it takes them too long.
    """

    scene: Scene
    criteria: Criteria
    stepped: bool


@dataclass(frozen=True)
class StressFamily:
    """Shots of one kind, over a range of a parameter.

    `name`: name on the command line, such as "grazing".
    `title`: a few words, for tables.
    `asks`: the expected result, in a sentence or two.
    `make`: yields the shots, the same at each call. The shots of the small size are part of the
        full size, or are smaller shots of the same kind.
    """

    name: str
    title: str
    asks: str
    make: Callable[[StressSize], Iterable[StressShot]]

    def shots(self, size: StressSize) -> Iterator[StressShot]:
        """Yield the shots; the name of each scene starts with the name of the family."""
        for one in self.make(size):
            named = {
                "name": f"{self.name}.{one.scene.name}",
                "tags": ("stress", self.name, *one.scene.tags),
            }
            yield StressShot(one.scene.model_copy(update=named), one.criteria, one.stepped)


def shot(
    name: str,
    scene: Scene,
    *limits: Criterion,
    truth: WantedTruth | None = None,
    proved: int | None = None,
    stepped: bool | None = None,
    **parameters: float,
) -> StressShot:
    """Return a shot of this name.

    `truth`, `proved`: see `Criteria`.
    `stepped`: see `StressShot`; default: True for short shots.
    `parameters`: the varied quantities with their values in this shot. They become tags such as
        "depth=0.1", from which the report computes where an engine begins to fail.
    """
    tags = tuple(f"{key.replace('_', ' ')}={value:g}" for key, value in parameters.items())
    short = lasts(scene) <= LONGEST if stepped is None else stepped
    asked = Criteria(truth=truth, proved=proved, criteria=limits)
    return StressShot(scene.model_copy(update={"name": name, "tags": tags}), asked, short)


def scene_of(
    *balls: Ball, physics: Physics, t_max: float | None, table: Table | None = None
) -> Scene:
    """Return a scene without a name of its own: `shot` gives it one."""
    return Scene(name="shot", balls=balls, physics=physics, t_max=t_max, table=table)


def limit(metric: str, reason: str, *, claiming: Claim | None = None, **most: Any) -> Criterion:
    """Return a limit for every engine, or for the engines with this claim."""
    given: dict[str, Any] = {"engines": (EVERY,), "metric": metric, "reason": reason}
    return Criterion(**given, claiming=claiming, if_measured=True, **most)


def lasts(scene: Scene) -> float:
    """Return an approximate upper bound on the duration of a shot [s].

    Twice the time in which friction stops its fastest ball: a collision may make a lighter ball
    faster.
    """
    slowing = float(np.min(scene.rolling_frictions)) * scene.physics.gravity
    surfaces = scene.radii * np.linalg.norm(scene.angular_velocities, axis=1)
    fastest = float(np.max(np.maximum(np.linalg.norm(scene.velocities, axis=1), surfaces)))
    until = 2.0 * fastest / slowing if slowing > 0.0 else math.inf
    return until if scene.t_max is None else min(until, scene.t_max)


def parameters_of(tags: Iterable[str]) -> dict[str, float]:
    """Return the varied quantities of a shot with their values, from the tags of its scene."""
    pairs = (tag.partition("=") for tag in tags)
    return {key: float(value) for key, equals, value in pairs if equals}


def power_of_ten(power: int) -> str:
    """Return a power of ten in the format for names of shots: "1e-07", "1e04"."""
    return f"1e{power:+03d}".replace("+", "")


def size_of(value: float) -> str:
    """Return a number in the format for names of shots: "0", "1e-07"."""
    return f"{value:.0e}".replace("+", "") if value else "0"
