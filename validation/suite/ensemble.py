"""Perturbed initial states of a shot, within a stated size.

Each perturbed state is a scene, computed only from the original scene, its index and the size. All
engines therefore run the same scenes, in any order and any process, and a larger ensemble starts
with the members of a smaller one.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Final, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field, ValidationError, model_validator

from ghostball.model import Ball, GhostballError, Scene, Table
from ghostball.validation.checks.motion_metrics import ENERGY_TIMES
from ghostball.validation.results.files import describe_problem
from ghostball.validation.runs.rolling import rolling_spin

LARGEST_POSITION = 0.25
"""Largest change of position, in units of the smallest radius: a ball that moves farther could
change places with its neighbour.
"""

SWEEPS = 256
"""Number of moves tried for each confined ball; with 16 times as many, gaps are only 5 % wider."""

FINEST = 8
"""Number of step sizes for confined balls, each half the one before: gaps deep in a rack are small.
"""

_LONGEST = 48
"""Characters of the original name that are kept in the name of a perturbed scene."""

_DRAWS = 4
"""Random numbers for each ball: speed, direction, x, y; drawn even if a number has no effect."""


MEMBER_METRICS: Final = ("pocketed_count", *ENERGY_TIMES)
"""Metrics on demand that the statistics of an ensemble need."""


class EnsembleError(GhostballError, ValueError):
    """An ensemble that can't be made: invalid number of members, or invalid size."""


class PerturbationSize(BaseModel, frozen=True, extra="forbid", allow_inf_nan=False):
    """Largest perturbation of the members of an ensemble; each number is drawn uniformly within it.

    `velocity` [1] and [rad]: relative change of the speed of each moving ball, and angle of
    rotation of its velocity about the vertical; both apply to the spin too. With more than a tenth
    of the speed, or 0.1 rad, it would be a different shot.
    `position` [m]: change of x and y of each ball.

    Raises `ValidationError` if a number is negative, not finite or too large, or if both are 0.
    """

    velocity: Annotated[float, Field(ge=0.0, le=0.1)] = 1e-3
    position: Annotated[float, Field(ge=0.0)] = 1e-4

    @model_validator(mode="after")
    def _not_nothing(self) -> Self:
        if self.velocity == self.position == 0.0:
            raise ValueError(
                "must not be 0 in both velocity and position: all members would be identical"
            )
        return self

    def __str__(self) -> str:
        return f"velocity={self.velocity:g},position={self.position:g}"

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read `velocity=1e-3,position=1e-4`; a missing number has its default.

        Raises `EnsembleError` if the text has another form, an unknown name, or an invalid size.
        """
        try:
            values = dict(piece.split("=") for piece in text.split(","))
            if len(values) < len(text.split(",")):
                raise ValueError
            return cls.model_validate(values)
        except ValidationError as error:
            why = describe_problem(error.errors()[0], [*cls.model_fields])
        except ValueError:
            why = f"must give each number once, by its name, got {text!r}"
        raise EnsembleError(
            f"the ensemble's size: {why}. Write it as velocity=1e-3,position=1e-4"
        ) from None

    def check(self, scene: Scene) -> None:
        """Refuse a size that is too large for a scene.

        Raises `EnsembleError` if balls could change places.
        """
        smallest = float(scene.radii.min())
        if self.position > LARGEST_POSITION * smallest:
            raise EnsembleError(
                f"`position` of the ensemble's size must be at most {LARGEST_POSITION:g} of the "
                f"smallest radius, {LARGEST_POSITION * smallest:g} m in scene "
                f'"{scene.name}", got {self.position:g} m: balls could change places'
            )


@dataclass(frozen=True)
class Ensemble:
    """Number of perturbed initial states of each scene, and their largest perturbation.

    Raises `EnsembleError` if the number is too small for a spread.
    """

    count: int
    size: PerturbationSize = PerturbationSize()  # noqa: RUF009 - frozen

    def __post_init__(self) -> None:
        if self.count < 2:
            raise EnsembleError(f"an ensemble needs at least 2 members, got {self.count}")

    def of(self, scene: Scene) -> list[Scene]:
        """Return all perturbed scenes of a scene."""
        return [varied(scene, self.size, index) for index in range(self.count)]


def varied(scene: Scene, size: PerturbationSize, index: int) -> Scene:
    """Return a scene with a perturbed initial state.

    `index`: from 0; a member doesn't depend on the number of members.

    The new scene is named after the original and the index. No ball overlaps another or leaves the
    table.

    Raises `EnsembleError` if the size is too large for the scene, or if `index` is negative.

    A ball with free space on all sides gets a uniform random position in the square of half side
    `position` around its original one. Balls that could then overlap, or leave the table, are
    *confined*: they start at their original positions and perform a random walk within their
    squares; a step that would cause an overlap isn't taken. The perturbation of touching balls, as
    in a frozen rack or at a cushion, thus only opens gaps; a ball without any free space stays
    where it is.

    Velocity and angular velocity are scaled by one factor and rotated by one angle, as if the tip
    hit the same spot; a rolling ball still rolls. A ball at rest stays at rest.
    """
    size.check(scene)
    if index < 0:
        raise EnsembleError(f"`index` of a member must be at least 0, got {index}")
    numbers = _Numbers(f"{scene.name}/shots/{index}")
    drawn = numbers.draw(_DRAWS * len(scene.balls)).reshape(-1, _DRAWS)
    places = _places(scene, size.position, drawn[:, 2:], numbers)
    rolls = scene.rolls
    balls = tuple(
        _moved(ball, place, _motion_of(ball, bool(rolls[i]), size.velocity * drawn[i, :2]))
        for i, (ball, place) in enumerate(zip(scene.balls, places, strict=True))
    )
    # Built from its fields, not copied, so that the constructor checks for overlaps.
    fields = {name: getattr(scene, name) for name in type(scene).model_fields}
    name = f"{scene.name[:_LONGEST]}.varied-{index + 1}"
    return Scene(**fields | {"name": name, "balls": balls})


class _Numbers:
    """Random numbers in [-1, 1), the same on every machine and with every version of numpy.

    numpy guarantees the bits of PCG64, but not those of its distributions.
    """

    def __init__(self, key: str) -> None:
        digest = hashlib.sha256(f"ghostball ensemble/{key}".encode()).digest()
        self._bits = np.random.PCG64(int.from_bytes(digest))

    def draw(self, count: int) -> NDArray[np.float64]:
        raw = np.asarray(self._bits.random_raw(count), dtype=np.uint64)
        drawn: NDArray[np.float64] = (raw >> np.uint64(11)).astype(np.float64) * 2.0**-52 - 1.0
        return drawn


def _moved(ball: Ball, place: Sequence[float], motion: Mapping[str, Any]) -> Ball:
    moved = ball.without_strike() if motion else ball
    return moved.model_copy(update={"position": (*place, ball.position[2]), **motion})


def _motion_of(ball: Ball, rolls: bool, drawn: NDArray[np.float64]) -> dict[str, Any]:
    """Return velocity and angular velocity, scaled and rotated about the vertical."""
    # The rotation uses the tangent of half the angle: the last bits of a sine differ between
    # machines, and the last bit matters in a break. The angle is uniform up to a relative error of
    # (angle)^2 / 4.
    factor, half = 1.0 + float(drawn[0]), 0.5 * float(drawn[1])
    sine, cosine = 2.0 * half / (1.0 + half * half), (1.0 - half * half) / (1.0 + half * half)

    def turned(vector: Sequence[float]) -> tuple[float, ...]:
        x, y, z = (factor * component for component in vector)
        return cosine * x - sine * y, sine * x + cosine * y, z

    if ball.speed == 0.0 and ball.angular_velocity is None:
        return {}
    velocity = turned(ball.velocity)
    if ball.angular_velocity is None:
        return {"velocity": velocity}
    spin = turned(ball.angular_velocity)
    if rolls:  # exact, because rounding errors of the rotation would be slip
        spin = rolling_spin(velocity, ball.radius, spin[2])
    return {"velocity": velocity, "angular_velocity": spin}


def _places(
    scene: Scene, size: float, drawn: NDArray[np.float64], numbers: _Numbers
) -> list[list[float]]:
    """Return x and y [m] of every ball."""
    room = _Room(scene, size)
    places: list[list[float]] = scene.positions[:, :2].tolist()
    if size == 0.0:
        return places
    for i in range(len(places)):
        if not room.confined[i]:
            places[i] = [x + size * float(d) for x, d in zip(places[i], drawn[i], strict=True)]
    confined = [i for i in range(len(places)) if room.confined[i]]
    if not confined:
        return places
    steps = numbers.draw(3 * SWEEPS * len(confined)).reshape(SWEEPS, -1, 3)
    halvings = np.floor(0.5 * (steps[:, :, 2] + 1.0) * FINEST)
    steps = steps[:, :, :2] * (size * 2.0**-halvings)[:, :, np.newaxis]
    order = list(enumerate(confined))
    for sweep in steps.tolist():
        for k, i in order:
            x, y = places[i][0] + sweep[k][0], places[i][1] + sweep[k][1]
            if room.has(i, x, y, places):
                places[i] = [x, y]
        order.reverse()  # so that neither end of a line of balls has an advantage
    return places


class _Room:
    """The places that a ball may take: within its square, on the table, without overlap."""

    def __init__(self, scene: Scene, size: float) -> None:
        centres, radii = scene.positions, scene.radii
        self.boxes = [_box(ball, scene.table, size) for ball in scene.balls]
        # On the cloth, balls touch in the plane of their centres; see "Coordinates" in
        # engine/__init__.
        heights = centres[:, 2] if scene.physics.airborne else np.zeros(len(radii))
        distance = np.hypot(*(centres[:, np.newaxis, :2] - centres[:, :2]).T)
        reach = np.add.outer(radii, radii)
        near = distance <= reach + 2.0 * math.sqrt(2.0) * size
        np.fill_diagonal(near, False)
        self.neighbours = [
            [(int(j), float(reach[i, j] ** 2 - (heights[i] - heights[j]) ** 2)) for j in found]
            for i, found in enumerate(map(np.flatnonzero, near))
        ]
        self.confined = [
            bool(neighbours) or box != _box(ball, None, size)
            for neighbours, box, ball in zip(self.neighbours, self.boxes, scene.balls, strict=True)
        ]

    def has(self, i: int, x: float, y: float, places: Sequence[Sequence[float]]) -> bool:
        """Return True if ball i can be at (x, y) [m] with the other balls at `places`."""
        left, right, bottom, top = self.boxes[i]
        if not (left <= x <= right and bottom <= y <= top):
            return False
        for j, reach_squared in self.neighbours[i]:
            dx, dy = x - places[j][0], y - places[j][1]
            if dx * dx + dy * dy <= reach_squared:
                return False
        return True


def _box(ball: Ball, table: Table | None, size: float) -> tuple[float, float, float, float]:
    """Return left, right, bottom and top of the region allowed for a centre [m]."""
    x, y, _ = ball.position
    box = [x - size, x + size, y - size, y + size]
    for side in () if table is None else table.sides:
        nearest = side.inside(ball.radius)
        most = max if side.normal[side.across] > 0.0 else min
        box[side.cushion] = most(box[side.cushion], nearest)
    left, right, bottom, top = box
    return left, right, bottom, top
