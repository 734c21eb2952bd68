"""Breaks as they are measured: random racks and hits, and what falls."""

from __future__ import annotations

import math
import random
import tomllib
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.resources import files
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from ghostball.engine import simulate_starts
from ghostball.model import POOL_BALL_RADIUS, Ball, EventKind, Physics, Result, Scene, Table
from ghostball.model.arrays import FloatArray
from ghostball.model.features import Capabilities, Feature, has_feature
from ghostball.model.scene.rack import ROWS, Kind, rack
from ghostball.validation.measured.best_settings import best_cloth, best_cushion

SCATTER_OF_FOLLOW = 0.1
"""Standard deviation of the forward spin, as part of that of rolling; assumed."""

SCATTER_OF_PLACE = 0.01
"""The cue ball starts at most this far from its place, if this isn't the middle [m]; assumed."""


class Setup(BaseModel, frozen=True, extra="forbid"):
    """Which balls lie where, and what the cue ball hits.

    `mouth` [m]: width of the mouths of the corner pockets.
    `target`: index in the rack of the ball that is aimed at.
    `on_spot`: index in the rack of the ball on the foot spot.
    `aside` [m]: distance of the cue ball's start from the middle of the head string.
    `offset` [radii]: distance of the cue ball's path from the target's centre, outwards.
    `follow`, `side`: spin, as part of that of rolling: forward, and about the vertical.

    The inputs "mouth", "aside", "offset", "follow" and "side" are added; see `breaks.toml`.
    """

    name: str
    table: str
    kind: Kind
    mouth: float
    target: int = 0
    on_spot: int = 0
    aside: float = 0.0
    offset: float = 0.0
    follow: float = 0.0
    side: float = 0.0

    @property
    def ids(self) -> list[str]:
        """The ids of all balls; the cue ball is the first."""
        return ["cue", *(name for row in ROWS[self.kind] for name in row)]

    def table_with(self, wider: float) -> Table:
        """Return the table, with mouths of the corner pockets that are wider by `wider` [m]."""
        fields = Table.model_validate(self.table).model_dump(mode="json", exclude={"preset"})
        fields["pockets"]["corner"]["mouth"] = self.mouth + wider
        return Table.model_validate(fields)


class Input(BaseModel, frozen=True, extra="forbid"):
    """A value of the model of a break, with its standard uncertainty and its source."""

    name: str
    meaning: str
    unit: str
    value: float
    error: float = Field(gt=0.0)
    source: str


class _Content(BaseModel, frozen=True, extra="forbid"):
    setups: tuple[Setup, ...]
    inputs: tuple[Input, ...]


class Starts(NamedTuple):
    """A scene, and initial states of its n balls in k breaks."""

    scene: Scene
    positions: FloatArray  # (k, n, 2) [m]
    velocities: FloatArray  # (k, n, 2) [m/s]
    spins: FloatArray  # (k, n, 3) [rad/s]

    def scenes(self) -> Iterator[Scene]:
        """Yield a scene for each break."""
        for places, velocities, spins in zip(*self[1:], strict=True):
            balls = [
                Ball(id=ball.id, position=tuple(x), velocity=(*v, 0.0), angular_velocity=tuple(w))
                for ball, x, v, w in zip(
                    self.scene.balls,
                    places.tolist(),
                    velocities.tolist(),
                    spins.tolist(),
                    strict=True,
                )
            ]
            yield Scene(**{**dict(self.scene), "balls": balls})


class BreakCounts(NamedTuple):
    """Numbers of breaks: all of them, and those in which a ball fell.

    `made`: a ball other than the cue ball. `clean`: another ball, and not the cue ball.
    `scratch`: the cue ball. `eight`: the 8, or the ball with this id.
    `balls`: number of balls that fell, without the cue ball.
    """

    breaks: int
    made: int
    clean: int
    scratch: int
    eight: int
    balls: int

    @classmethod
    def of(cls, fell: NDArray[np.bool_], eight: int) -> BreakCounts:
        """Count the breaks in which balls fell, (k, n) bool; `eight` is the index of the 8."""
        made, scratch = fell[:, 1:].any(axis=1), fell[:, 0]
        numbers = (made, made & ~scratch, scratch, fell[:, eight], fell[:, 1:])
        return cls(len(fell), *(int(np.count_nonzero(one)) for one in numbers))


def setups() -> tuple[Setup, ...]:
    """Return the setups of measured breaks; they are numbered from 1 on."""
    return _content().setups


def setup_of(name: str) -> Setup:
    """Return the setup with a name."""
    return next(one for one in setups() if one.name == name)


def inputs() -> tuple[Input, ...]:
    """Return the uncertain inputs of the breaks."""
    return _content().inputs


@cache
def _content() -> _Content:
    text = (files("ghostball.validation.measured") / "breaks.toml").read_text(encoding="utf-8")
    return _Content.model_validate(tomllib.loads(text))


def break_physics(
    engine: str, capabilities: Capabilities, values: Mapping[str, float], impacts: str = ""
) -> dict[str, Any] | None:
    """Return the fields of the physics of a break on an engine.

    Return None if the engine has no cushion law with known coefficients.

    The engine gets the law of the cushion that fits banks best, and the cloth that fits rolling
    balls best. `values` are those of the inputs, by name; a cushion law other than that of
    Ghostball's engine keeps its own restitution.

    `impacts`: how impacts of several balls are resolved; by default, `compliant` if the engine
    supports this, else `simultaneous`.
    """
    cushion = best_cushion("banks-pool", engine, capabilities)
    if cushion is None:
        return None
    cloth = best_cloth("rolling-pool", capabilities)
    if cloth["rolling_friction_quadratic"] > 0.0:
        cloth["rolling_friction"] = values["rolling_friction"]
    if cushion["cushion"] == "mathavan2010":
        cushion["cushion_restitution"] = values["cushion_restitution"]
    lasts = has_feature(capabilities, Feature.COMPLIANT)
    fields = {
        "motion": "sliding",
        "impacts": impacts or ("compliant" if lasts else "simultaneous"),
        "cushion_height": Physics(preset="pool").cushion_height,
        "cushion_friction": values["cushion_friction"],
        **{name: values[name] for name in ("ball_restitution", "ball_friction")},
        "sliding_friction": values["sliding_friction"],
        **cloth,
        **cushion,
    }
    if fields["impacts"] == "compliant":
        fields["ball_youngs_modulus"] = values["ball_youngs_modulus"]
    if cushion["cushion"] == "frictional":
        del fields["cushion_height"]  # this law has no nose
    return fields


def values_of(**changed: float) -> dict[str, float]:
    """Return the value of each input by name; `changed` replaces some of them."""
    return {one.name: one.value for one in inputs()} | changed


def starts_of(
    setup: Setup, physics: Physics, values: Mapping[str, float], count: int, first: int = 0
) -> Starts:
    """Return `count` random breaks; break number k is always the same for the same values."""
    table = setup.table_with(values["mouth"])
    aside, offset, side = (
        getattr(setup, name) + (values[name] if getattr(setup, name) else 0.0)
        for name in ("aside", "offset", "side")
    )
    n = len(setup.ids)
    positions, velocities, spins = (np.zeros((count, n, size)) for size in (2, 2, 3))
    for k in range(count):
        chance = random.Random(f"break {first + k}")
        balls = rack(
            setup.kind,
            table,
            gap=values["gap"],
            unevenness=values.get("unevenness"),
            seed=chance.getrandbits(62),
        )
        places = np.array([ball.position[:2] for ball in balls])
        places[:, 0] += places[0, 0] - places[setup.on_spot, 0]
        speed = chance.gauss(values["speed"], values["speed_scatter"])
        follow = setup.follow + chance.gauss(values["follow"], SCATTER_OF_FOLLOW)
        beside = (offset + chance.gauss(0.0, values["aim"])) * POOL_BALL_RADIUS
        scatter = chance.uniform(-SCATTER_OF_PLACE, SCATTER_OF_PLACE) if setup.aside else 0.0
        start = np.array([0.25 * table.length, 0.5 * table.width + aside + scatter])
        way = places[setup.target] - start
        way /= math.hypot(*way)
        left = np.array([-way[1], way[0]])
        positions[k, 0], positions[k, 1:] = start + beside * left, places
        velocities[k, 0] = speed * way
        spins[k, 0, :2] = follow * speed / POOL_BALL_RADIUS * left
        spins[k, 0, 2] = side * speed / POOL_BALL_RADIUS
    all_balls = [
        Ball(id=name, position=tuple(place))
        for name, place in zip(setup.ids, positions[0].tolist(), strict=True)
    ]
    scene = Scene(name="break", table=table, physics=physics, balls=all_balls)
    return Starts(scene, positions, velocities, spins)


def count_breaks(setup: Setup, starts: Starts) -> BreakCounts:
    """Simulate breaks on Ghostball's engine, and count those in which something falls."""
    batch = simulate_starts(*starts)
    return BreakCounts.of(batch.pocketed >= 0, _eight(setup))


def fallen(result: Result) -> NDArray[np.bool_]:
    """Return which balls fell in a recorded shot, (n,) bool."""
    assert result.events is not None
    fell = result.events["a"][result.events["kind"] == EventKind.POCKETED]
    return np.isin(np.arange(len(result.scene.balls)), fell)


def counts_of_results(setup: Setup, fell: list[NDArray[np.bool_]]) -> BreakCounts:
    """Count the breaks of any engine; `fell` holds the result of `fallen` for each break."""
    return BreakCounts.of(np.array(fell), _eight(setup))


def _eight(setup: Setup) -> int:
    return setup.ids.index("8")
