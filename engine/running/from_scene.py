"""Convert a scene to the arrays that the kernels work on: once per scene, and copied for each run.

The arrays are balls, laws, and memory for schedulers, contacts and the log. `obstacle_rows` makes
the obstacles.
"""

from __future__ import annotations

import math
import weakref
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from ghostball.engine.capabilities import CAPABILITIES
from ghostball.engine.core import state as st
from ghostball.engine.core.block import Block
from ghostball.engine.core.rows import STATE_COLUMNS
from ghostball.engine.core.state import (
    Balls,
    BoolArray,
    Cells,
    FloatArray,
    IntArray,
    Laws,
    Pairs,
)
from ghostball.engine.impacts.hertz import loss_of
from ghostball.engine.running.obstacle_rows import obstacles_of, outer_of
from ghostball.engine.running.skips import Skip, is_uniform, uses_cells
from ghostball.engine.running.variants import Variant, variant_of
from ghostball.model import CUSHIONS, Ball, Physics, Scene, UnsupportedSceneError
from ghostball.model.features import Feature, check_supported, has_feature
from ghostball.model.impact_laws import BALL_LAW_NAMES
from ghostball.model.scene import check_whole
from ghostball.model.scene.contents import rolls_alone
from ghostball.model.trajectory.polynomial import PER_POWER

_T_MAX = Laws._fields.index("t_max")

_CELL_ROOM = 2.0**-20
"""Relative excess of a cell's side over the largest diameter: a margin for rounding."""

_COMPLIANT_CELL_ROOM = 0.25
"""The same if impacts last: cells must give every ball that a leg of a cluster can reach."""


_CLOTH_OF_CELL = 0.03
"""Smallest area of a cell, relative to the area of cloth per ball.

A rack is far denser than the cloth as a whole. With cells of half the area per ball, 300 balls of a
rack of 512 were within reach of each other, and an event took four times as many bounds.
"""


@dataclass(frozen=True, eq=False)
class SceneLayout:
    """A scene as the kernels get it at the start of a shot. Its arrays must not be modified."""

    block: Block  # balls and data of their scheduler at the start of each shot
    laws: FloatArray  # the numbers of its `Laws`, in their order: kernels take only arrays
    obstacles: FloatArray
    radii: FloatArray
    smallest_radius: float
    variant: Variant  # which kernel
    columns: int  # number of columns of `Log.motion`
    # Each `Workplace` that no shot uses now; a layout with another end starts with none.
    idle: list[Any] = field(default_factory=list, init=False)

    @cached_property
    def arguments(self) -> tuple[Any, ...]:
        """The last arguments of the kernel, which are the same in each call for a scene."""
        return (
            self.block.numbers,
            self.block.offsets,
            1 if self.variant is Variant.FULL else None,
            self.laws,
            self.obstacles,
        )

    @property
    def count(self) -> int:
        """Number of balls."""
        return len(self.radii)

    def ending(self, t_max: float) -> SceneLayout:
        """Return the layout of the scene with another end [s]."""
        laws = self.laws.copy()
        laws[_T_MAX] = t_max
        return replace(self, laws=laws)

    @property
    def state(self) -> FloatArray:
        """`Balls.state` at the start of a shot, (n, STATE_COLUMNS)."""
        return self.block.numbers[: self.count * STATE_COLUMNS].reshape(self.count, STATE_COLUMNS)


def admit(scene: Scene) -> None:
    """Refuse a scene that breaks a rule of scenes, or needs physics that this engine lacks.

    Every path from a scene to the kernels needs a layout, and only admitted scenes get one.

    Raises `SceneError` or `UnsupportedSceneError`.
    """
    if not _is_admitted(scene):
        check_whole(scene)
        if _LACKS:
            check_supported("ghostball", CAPABILITIES, scene)
        if scene.table is not None:
            _check_count(scene, len(scene.table.sides) + len(scene.table.obstacles))
        key = id(scene)
        _LAYOUTS[key] = (weakref.ref(scene, lambda _: _LAYOUTS.pop(key, None)), {})


_LACKS = any(not has_feature(CAPABILITIES, feature) for feature in Feature)
"""Whether any feature is unsupported by this engine."""


def _check_count(scene: Scene, obstacles: int) -> None:
    """Refuse a table with more obstacles than the kernels have bits for."""
    if obstacles > st.MOST_OBSTACLES:
        table = scene.table
        many = table is not None and len(table.vertices) > len(table.posts)
        lacks = (
            f"`table.{'vertices' if many else 'posts'}` must leave at most {st.MOST_OBSTACLES} "
            f"obstacles on the table (cushions, posts, and five for each pocket), got {obstacles}. "
            "Remove some, or use another engine"
        )
        raise UnsupportedSceneError("ghostball", (lacks,))


def _is_admitted(scene: Scene) -> bool:
    """Return whether `admit` has already accepted this scene."""
    kept = _LAYOUTS.get(id(scene))
    return kept is not None and kept[0]() is scene


def layout_of(scene: Scene, off: frozenset[Skip] = frozenset()) -> SceneLayout:
    """Return the layout of a scene, made on first use and kept as long as the scene exists.

    The key is the scene's identity. Two equal scenes have two layouts, because comparing scenes
    would take longer.

    Raises `SceneError` or `UnsupportedSceneError`, see `admit`.
    """
    kept = _LAYOUTS.get(id(scene))
    if kept is None or kept[0]() is not scene:
        admit(scene)
        kept = _LAYOUTS[id(scene)]
    layout = kept[1].get(off)
    if layout is None:
        layout = kept[1][off] = _laid_out(scene, off)
    return layout


def _laid_out(scene: Scene, off: frozenset[Skip]) -> SceneLayout:
    laws, n = laws_of(scene, off), len(scene.balls)
    variant, radii = variant_of(scene, off), scene.radii
    radii.flags.writeable = False
    if uses_cells(scene, off):
        blank = Block(blank_balls(n, variant), pairs_of(0), cells_of(scene), most_contacts(n))
    else:
        blank = blank_block(n, variant)
    height = height_of(scene) if variant is Variant.FULL else None
    return SceneLayout(
        block=blank.begun(state_of(scene), height),
        laws=np.array(laws[:-1], dtype=np.float64),
        obstacles=laws.obstacles,
        radii=radii,
        smallest_radius=float(radii.min()),
        variant=variant,
        columns=_COLUMNS[variant],
    )


@lru_cache(maxsize=8)
def blank_block(n: int, variant: Variant) -> Block:
    """Return the block of n balls, with a bound for each pair, before their states are set.

    Scenes with the same number of balls share this block.
    """
    return Block(blank_balls(n, variant), pairs_of(n), None, most_contacts(n))


_COLUMNS = {
    Variant.LEAN: st.SEGMENT_COLUMNS,
    # The additional columns are RISE, UP_SPEED and FALL, then the powers.
    Variant.FULL: st.SEGMENT_COLUMNS + 3 + PER_POWER * st.MOST_POWERS,
}
"""Number of columns of `Log.motion`."""

_LAYOUTS: dict[int, tuple[weakref.ref[Scene], dict[frozenset[Skip], SceneLayout]]] = {}
"""The layouts of each scene, by the skips that are switched off."""


def state_of(scene: Scene) -> FloatArray:
    """Return `Balls.state` at the start of a shot, (n, STATE_COLUMNS)."""
    state = np.zeros((len(scene.balls), STATE_COLUMNS))
    state[:, _GIVEN] = [_row_of(ball, scene.physics) for ball in scene.balls]
    state[:, st.OWN_TIME] = np.inf
    return state


_GIVEN = (
    *(st.X, st.Y, st.VX, st.VY, st.WX, st.WY, st.WZ, st.PHASE, st.RADIUS, st.MASS),
    *(st.ROLL_SLOWING, st.SLIDE_SLOWING, st.SPIN_SLOWING, st.CLOTH_FRICTION),
)
"""Columns of `Balls.state` that a scene gives."""


def _row_of(ball: Ball, physics: Physics) -> tuple[float, ...]:
    """Return the numbers of a ball at the start of a shot, in the order of `_GIVEN`.

    For 16 balls this takes less than half the time of numpy arrays.
    """
    (x, y, z), (vx, vy, up), radius = ball.position, ball.velocity, ball.radius
    spin, slides = ball.angular_velocity, physics.motion == "sliding"
    rolls = not slides or spin is None or rolls_alone(ball.velocity, spin, radius)
    phase = st.FLYING if z > radius or up > 0.0 else st.ROLLING if rolls else st.SLIDING
    wx, wy, wz = (-vy / radius, vx / radius, 0.0) if spin is None else spin
    roll, slide, rate = ball.rolling_friction, ball.sliding_friction, ball.spinning_friction_rate
    roll = physics.rolling_friction if roll is None else roll
    slide = physics.sliding_friction if slide is None else slide
    rate = physics.spinning_friction_rate if rate is None else rate
    slowing = slide * physics.gravity if slides else 0.0
    mass, rolling = ball.mass, roll * physics.gravity
    return x, y, vx, vy, wx, wy, wz, phase, radius, mass, rolling, slowing, rate, slide


def blank_balls(n: int, variant: Variant) -> Balls:
    """Return n balls before their states are set.

    All are marked: the kernel then sets accelerations and own events.
    """
    full = variant is Variant.FULL
    return Balls(
        np.zeros((n, STATE_COLUMNS)),
        np.zeros(n, dtype=np.int64),
        np.ones(n, dtype=np.bool_),
        np.concatenate(([n], np.arange(n))).astype(np.int32),
        np.zeros((max(_most_pairs(n) + 1, 2), 2), dtype=np.int32),
        np.zeros(n, dtype=np.int32),
        np.zeros(st.COUNTERS, dtype=np.int64),
        np.zeros((n, st.POWERS_COLUMNS)) if full else None,
        np.zeros((st.SERIES_ROWS, st.SERIES_TERMS)) if full else None,
        np.zeros((n, st.HEIGHT_COLUMNS)) if full else None,
    )


def phases_of(rolls: BoolArray, rises: BoolArray, slides: bool) -> FloatArray:
    """Return the initial phases of balls that roll, or rise from the cloth, or else slide."""
    phases: FloatArray = np.where(
        rises, st.FLYING, np.where(rolls | (not slides), st.ROLLING, st.SLIDING)
    )
    return phases


def height_of(scene: Scene) -> FloatArray:
    """Return `Balls.height` at the start; BASE is 0 for all balls if none may leave the cloth."""
    height = np.zeros((len(scene.balls), st.HEIGHT_COLUMNS))
    height[:, st.STILL_RISE] = -1.0  # below the cloth, where no ball can be
    if scene.physics.airborne:
        height[:, st.BASE] = scene.radii
        height[:, st.RISE] = scene.positions[:, 2] - scene.radii
        height[:, st.UP_SPEED] = scene.velocities[:, 2]
    return height


def laws_of(scene: Scene, off: frozenset[Skip] = frozenset()) -> Laws:
    """Return the scene's physics and table as the numbers that the kernel uses.

    Raises `UnsupportedSceneError` if there are more obstacles than `MOST_OBSTACLES`.
    """
    physics = scene.physics
    obstacles = obstacles_of(scene, off)
    _check_count(scene, len(obstacles))
    speed_dependent = physics.ball_friction == "alciatore"
    return Laws(
        slides=physics.motion == "sliding",
        uniform=is_uniform(scene) and Skip.ADVANCEMENT not in off,
        simultaneous=physics.impacts != "sequential",
        ball_law=BALL_LAW_NAMES.index(physics.ball_impact),
        ball_restitution=float(physics.ball_restitution),
        ball_friction=0.0 if speed_dependent else float(physics.ball_friction),
        speed_dependent=speed_dependent,
        t_max=np.inf if scene.t_max is None else float(scene.t_max),
        air_drag=float(physics.air_drag),
        airborne=physics.airborne,
        gravity=float(physics.gravity),
        table_restitution=float(physics.table_restitution),
        roll_quadratic=float(physics.rolling_friction_quadratic),
        outer=outer_of(scene, len(obstacles), off),
        frame_x=0.0 if scene.table is None else scene.table.length,
        frame_y=0.0 if scene.table is None else scene.table.width,
        compliant=physics.impacts == "compliant",
        contact_modulus=contact_modulus(physics),
        contact_loss=loss_of(physics.ball_restitution) if physics.impacts == "compliant" else 0.0,
        obstacles=obstacles,
    )


def contact_modulus(physics: Physics) -> float:
    """Return E* [Pa] of Hertz's law for the contact of two balls of the scene's material."""
    return physics.ball_youngs_modulus / (2.0 * (1.0 - physics.ball_poissons_ratio**2))


@lru_cache(maxsize=8)
def pairs_of(n: int) -> Pairs:
    """Return arrays for the bounds of n balls; scenes with n balls share them, runs copy them."""
    blocks = -(-n // st.TRACK_BALLS)
    return Pairs(
        bound=np.full(n * n, np.inf),
        least=np.full(n, np.inf),
        next=np.full(n, np.inf),
        track=np.zeros(blocks * st.TRACKS * st.TRACK_BALLS),
    )


def cells_of(scene: Scene) -> Cells:
    """Divide the cloth into cells: about thirty per ball, none smaller than the largest ball.

    This also works for balls spread along a line.
    """
    n, positions = len(scene.balls), scene.positions[:, :2]
    low, high = np.min(positions, axis=0), np.max(positions, axis=0)
    if scene.table is not None and scene.table.cushions:
        low, high = np.zeros(2), np.array([scene.table.length, scene.table.width])
    extent = np.maximum(high - low, 2.0 * float(np.max(scene.radii)))
    room = _COMPLIANT_CELL_ROOM if scene.physics.impacts == "compliant" else _CELL_ROOM
    side = 2.0 * float(np.max(scene.radii)) * (1.0 + room)
    cloth = _CLOTH_OF_CELL * float(np.prod(extent)) / n
    side = max(side, math.sqrt(cloth), float(np.max(extent)) / (2.0 * n))
    size = np.maximum(np.floor(extent / side).astype(np.int64), 1)
    leaves = 1 << (n - 1).bit_length()

    return Cells(
        frame=np.array([*low, side, 2.0 * float(np.max(scene.radii)), -np.inf, 0.0]),
        size=size,
        first=np.full(int(np.prod(size + 2)), st.NOWHERE, dtype=np.int32),
        link=np.zeros((n, st.LINK_COLUMNS), dtype=np.int32),
        slot=np.full((n, st.SLOT_COLUMNS), np.inf),
        tree=np.full(2 * leaves, np.inf),
    )


def most_contacts(n: int) -> int:
    """Return the largest number of contacts of n balls, with each other and with cushions."""
    return _most_pairs(n) + len(CUSHIONS) * n


def _most_pairs(n: int) -> int:
    """Return how many pairs of n balls can touch at once: a planar graph has at most 3 n edges.

    More pairs touch if gaps can't be resolved, between balls hardly larger than the rounding of
    their coordinates. Such a run stops, see `NO_ROOM`.
    """
    return min(n * (n - 1) // 2, 3 * n)


def log_of(
    capacity: int, n: int, columns: int = st.SEGMENT_COLUMNS
) -> tuple[FloatArray, IntArray, IntArray, FloatArray]:
    """Return the four arrays of a `Log`, for `capacity` events of n balls.

    Most events change two balls, one may change all. Each motion has `columns` numbers.
    """
    motions = 2 * capacity + n if capacity else 0
    return (
        np.empty(capacity),
        np.empty((3, capacity), dtype=np.int64),
        np.empty(motions, dtype=np.int64),
        np.empty((motions, columns)),
    )
