"""Second shots that the laws of motion relate to a first one, and how the two are related.

    >>> related = mirror(result)
    >>> related.scene, related.expected(times, positions_of_the_second_shot)

Each relation changes the scene of a shot. The second shot must then be the first one, seen from
another side, in other units, or later: `RelatedShot.expected` turns its positions back into those
of the first shot. No relation needs a reference result, so relations can judge shots with flights,
air, pockets or chaos, too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ghostball.model import (
    Ball,
    EventKind,
    GhostballError,
    Physics,
    Result,
    Scene,
    SceneError,
    Table,
)
from ghostball.model.arrays import FloatArray
from ghostball.model.impact_laws import CUSHION_LAWS
from ghostball.validation.checks.metric import NotMeasuredError
from ghostball.validation.checks.moved_scenes import SAME, moved, table_from
from ghostball.validation.grading.horizon import extent_of, first_balance, hits_corner
from ghostball.validation.grading.tolerances import LOWEST_BOUNCE
from ghostball.validation.runs.sampling import events_of, frames_of

_QUARTER_TURN: Final = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
_HALF_TURN: Final = np.diag([-1.0, -1.0, 1.0])
_SWAP: Final = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
_FLIP: Final = np.diag([1.0, -1.0, 1.0])

_LONGEST_NAME: Final = 48
"""Number of characters of a scene's name that the name of its second shot keeps."""

_BOOST: Final = (0.5, 0.25)
"""Added velocity along x and y, in units of the fastest speed; powers of two round least."""

_FAR: Final = 16.0
"""Least distance of the far ball on an unbounded cloth, in units of the largest coordinate."""

_GRID: Final = 24
"""Number of places along each side of a table at which the far ball may be put."""

_LINES: Final = 64
"""Number of lines of a path whose distances are computed together: they fit into a cache."""

_MIDDLE: Final = (0.25, 0.75)
"""Part of a shot in which it is cut, in units of its duration."""


@dataclass(frozen=True, eq=False)
class RelatedShot:
    """A second shot and its relation to the first.

    A position p of the first shot at the time t corresponds to `unit` * `turn` @ p + `shift` +
    `speed` * t in the second, at the time `clock` * (t - `start`).

    `scene`: of the second shot.
    `exact`: whether the relation changes no digit of a number of the scene. An engine that treats
        directions, balls and units alike then gives the same bits.
    `turn` (3, 3): a rotation or reflection in the plane, of 0, 1 and -1.
    `shift` (3,) [m], `speed` (3,) [m/s].
    `unit`, `clock`: new units of length and time.
    `start` [s]: time of the first shot at which the second begins.
    `order`: index in the second shot of each ball of the first; -1 if it isn't there.
    `added`: indices of balls of the second shot that the first doesn't have.
    """

    scene: Scene
    exact: bool
    order: tuple[int, ...]
    turn: FloatArray = field(default_factory=lambda: SAME)
    shift: FloatArray = field(default_factory=lambda: np.zeros(3))
    speed: FloatArray = field(default_factory=lambda: np.zeros(3))
    unit: float = 1.0
    clock: float = 1.0
    start: float = 0.0
    added: tuple[int, ...] = ()

    @property
    def kept(self) -> NDArray[np.intp]:
        """Indices in the first shot of the balls that the second has, (k,)."""
        return np.flatnonzero(np.array(self.order) >= 0)

    def times(self, times: FloatArray) -> FloatArray:
        """Return the times of the second shot for times of the first, (m,) [s]."""
        theirs: FloatArray = self.clock * (times - self.start)
        return theirs

    def expected(self, times: FloatArray, positions: FloatArray) -> FloatArray:
        """Return the positions that the first shot must have, (m, k, 3) [m], for `kept` balls.

        `times` (m,) [s]: of the first shot.
        `positions` (m, n, 3) [m]: of the second shot at `self.times(times)`.
        """
        theirs = positions[:, [index for index in self.order if index >= 0]]
        there = theirs - self.shift - self.speed * times[:, np.newaxis, np.newaxis]
        # Each component is a sum of one number and zeros, so only the shifts round.
        back: FloatArray = there @ self.turn / self.unit
        return back


def rotate(result: Result) -> RelatedShot:
    """Turn everything by 90 degrees, or by 180 if the table has side pockets."""
    turn = _HALF_TURN if _has_side_pockets(result.scene) else _QUARTER_TURN
    return _seen_from(result.scene, "rotate", turn, exact=result.scene.table is None)


def mirror(result: Result) -> RelatedShot:
    """Swap x and y, or only reverse y if the table has side pockets."""
    scene = result.scene
    if _has_side_pockets(scene):
        return _seen_from(scene, "mirror", _FLIP, exact=False)
    # A mirrored polygon has its vertices in reverse order.
    exact = not depends_on_direction(result) and (scene.table is None or not scene.table.vertices)
    return _seen_from(scene, "mirror", _SWAP, exact=exact)


def translate(result: Result) -> RelatedShot:
    """Shift all balls; a table without the cushion at x = 0 or y = 0 becomes longer or wider."""
    scene = result.scene
    table = scene.table
    extent = 2.0 ** math.ceil(math.log2(extent_of(scene)))
    free = np.array([extent, 0.5 * extent, 0.0])
    if table is not None:
        if table.obstacles or scene.physics.airborne:
            raise NotMeasuredError("the place of the table is fixed")
        free *= ("left" not in table.cushions, "bottom" not in table.cushions, False)
        if not np.any(free):
            raise NotMeasuredError("the cushions at x = 0 and y = 0 have a fixed place")
        size = {"length": table.length + free[0], "width": table.width + free[1]}
        table = Table(cushions=table.cushions, **size)
    balls = [moved(ball, shift=free) for ball in scene.balls]
    made = _scene(scene, "translate", balls, table=table)
    return RelatedShot(made, False, _in_order(balls), shift=free)


def renumber(result: Result) -> RelatedShot:
    """List the balls in reverse order."""
    scene = result.scene
    if len(scene.balls) < 2:
        raise NotMeasuredError("the scene has only one ball")
    if scene.physics.impacts == "sequential" and len(scene.balls) > 2:
        raise NotMeasuredError('`impacts` = "sequential" depends on the order of the balls')
    balls = [moved(ball) for ball in reversed(scene.balls)]
    exact = not depends_on_order(result)
    return RelatedShot(_scene(scene, "renumber", balls), exact, _in_order(balls)[::-1])


def scale(result: Result) -> RelatedShot:
    """Double the units of length and time, so that speeds keep their numbers.

    Masses grow by 8, so that densities and elastic constants keep their numbers.
    """
    scene, old = result.scene, result.scene.physics
    law = next(law for law in CUSHION_LAWS if law.name == old.cushion)
    changed = {
        "gravity": 0.5 * old.gravity,
        "spinning_friction_rate": 0.25 * old.spinning_friction_rate,
        "air_drag": 0.5 * old.air_drag,
        "rolling_friction_quadratic": 0.5 * old.rolling_friction_quadratic,
    }
    if "cushion_height" in law.uses or old.airborne:
        changed["cushion_height"] = 2.0 * old.cushion_height
    physics = Physics.model_validate(dict(old) | changed)
    table = scene.table
    if table is not None:
        table = table_from(table, SAME, np.zeros(3), unit=2.0)
    balls = [moved(ball, unit=2.0, clock=2.0) for ball in scene.balls]
    t_max = None if scene.t_max is None else 2.0 * scene.t_max
    made = _scene(scene, "scale", balls, table=table, physics=physics, t_max=t_max)
    return RelatedShot(made, True, _in_order(balls), unit=2.0, clock=2.0)


def boost(result: Result) -> RelatedShot:
    """Add one velocity to all balls; for balls that nothing else touches."""
    scene, physics = result.scene, result.scene.physics
    if scene.table is not None:
        raise NotMeasuredError("a table that moves can't be described")
    slides = physics.motion == "sliding" and np.any(scene.sliding_frictions)
    slowed = slides or np.any(scene.rolling_frictions)
    if slowed or physics.air_drag or physics.rolling_friction_quadratic:
        raise NotMeasuredError("cloth or air slows the balls, and neither can move with them")
    fastest = float(np.max(np.linalg.norm(scene.velocities, axis=1)))
    if fastest == 0.0:
        raise NotMeasuredError("nothing moves")
    speed = np.array([*(part * fastest for part in _BOOST), 0.0])
    spins = scene.angular_velocities.tolist() if physics.motion == "sliding" else None
    balls = [
        moved(ball, speed=speed, spin=None if spins is None else spins[i])
        for i, ball in enumerate(scene.balls)
    ]
    return RelatedShot(_scene(scene, "boost", balls), False, _in_order(balls), speed=speed)


def split(result: Result, until: float = math.inf) -> RelatedShot:
    """Cut the shot in its middle, in the longest time without events, and go on from there.

    `until` [s]: if it comes before the end, the shot is cut in the middle of this time.
    """
    scene = result.scene
    low, high = (part * min(result.rest_time, until) for part in _MIDDLE)
    times = events_of(result)["t"]
    marks = np.unique([low, *times[(times > low) & (times < high)], high])
    if high <= low:
        raise NotMeasuredError("nothing moves, or the shot is unpredictable from its start")
    longest = int(np.argmax(np.diff(marks)))
    start = float(0.5 * (marks[longest] + marks[longest + 1]))
    frames = frames_of(result)
    if frames is not None:  # a state between two frames is interpolated, and no state of the engine
        start = float(frames.times[np.argmin(np.abs(frames.times - start))])
    if scene.physics.airborne and _bounces_low(scene, *result.sample([start])[:2]):
        raise NotMeasuredError(f"at t = {start:.6g} s a ball lies on another, or bounces too low")
    try:
        made = result.at(start, name=_name(scene, "split"))
    except GhostballError as error:
        raise NotMeasuredError(f"its state at {start:.6g} s can't start a shot: {error}") from error
    places = {ball.id: k for k, ball in enumerate(made.balls)}
    order = tuple(places.get(ball.id, -1) for ball in scene.balls)
    return RelatedShot(made, False, order, start=start)


def far_ball(result: Result) -> RelatedShot:
    """Add a ball that rests where nothing comes near."""
    scene = result.scene
    times = np.union1d(events_of(result)["t"], np.linspace(0.0, result.rest_time, 257))
    times = np.append(times, times[-1])  # a path needs two times, also of a shot that ends at once
    paths = result.sample(times).positions[:, :, :2]
    radius, mass = float(np.min(scene.radii)), float(np.min(scene.masses))
    clear = radius + 2.0 * float(np.max(scene.radii))
    name = "far"
    while any(ball.id == name for ball in scene.balls):
        name += "-"
    for place in _far_places(scene, paths, clear):
        ball = Ball(id=name, position=place, radius=radius, mass=mass)
        balls = [*(moved(one) for one in scene.balls), ball]
        try:
            made = _scene(scene, "far-ball", balls)
        except SceneError:  # a hole or a post is there
            continue
        added = len(scene.balls)
        return RelatedShot(made, True, _in_order(scene.balls), added=(added,))
    raise NotMeasuredError("there is no free place that no ball comes near")


SECOND_SHOTS: Final[dict[str, Callable[[Result], RelatedShot]]] = {
    "rotate": rotate,
    "translate": translate,
    "mirror": mirror,
    "renumber": renumber,
    "scale": scale,
    "boost": boost,
    "split": split,
    "far-ball": far_ball,
}
"""Every relation by name, in the order of reports: the function returns the second shot of a run.

Each raises `NotMeasuredError` if the relation doesn't exist for the scene.
"""


def depends_on_direction(result: Result) -> bool:
    """Return whether a mirror image of a shot may round differently.

    Forces of contacts that last are found one after another, in an order that depends on places. A
    ball in a corner hits two cushions one after the other, although they are due at one instant. A
    ball that balances on another ball falls in a fixed direction.
    """
    steps = result.work.get("contact_steps", 0) > 0
    return steps or first_balance(result) < math.inf or hits_corner(result)


def depends_on_order(result: Result) -> bool:
    """Return whether the order of the balls may change the last bits of a run of an exact engine.

    The forces of contact steps are found one after another, and those of compliant impacts are
    summed in the order of the balls.
    """
    order_of_sums = ("contact_steps", "compliant_impacts")
    return any(result.work.get(name) for name in order_of_sums) or hits_two_in_turn(result)


def hits_two_in_turn(result: Result) -> bool:
    """Return whether a ball hits two others at one instant, and the engine resolves one hit first.

    Hits are resolved together if `impacts` is "simultaneous" and `airborne` is false.
    """
    physics = result.scene.physics
    if physics.impacts == "simultaneous" and not physics.airborne:
        return False
    log = events_of(result)
    log = log[log["kind"] == EventKind.BALL_BALL]
    met: dict[tuple[float, int], int] = {}  # the ball that each ball meets at each instant
    for t, _, a, b in log.tolist():
        if met.setdefault((t, a), b) != b or met.setdefault((t, b), a) != a:
            return True
    return False


def _bounces_low(scene: Scene, positions: FloatArray, velocities: FloatArray) -> bool:
    """Return whether a ball off the cloth bounces lower than `LOWEST_BOUNCE`, or lies on a ball.

    An engine may treat all bounces of this height as one motion, whose state a scene can't hold.

    `positions`, `velocities` (1, n, 3) [m], [m/s].
    """
    places, speeds, radii = positions[0], velocities[0], scene.radii
    twice_gravity = 2.0 * scene.physics.gravity
    for i in np.flatnonzero(places[:, 2] > radii):
        rise = places[i, 2] - radii[i] + speeds[i, 2] ** 2 / twice_gravity
        if rise < 2.0 * LOWEST_BOUNCE * radii[i]:
            return True
        away = np.delete(places - places[i], i, axis=0)
        apart = np.linalg.norm(away, axis=1)
        rates = np.sum(away * np.delete(speeds - speeds[i], i, axis=0), axis=1) / apart
        reach = np.delete(radii + radii[i], i)
        # Twice the height, because only a part of gravity acts along an inclined normal.
        if np.any(apart - reach + rates**2 / twice_gravity < 2.0 * LOWEST_BOUNCE * reach):
            return True
    return False


def _far_places(scene: Scene, paths: FloatArray, clear: float) -> Sequence[tuple[float, float]]:
    """Return places that are at least `clear` [m] away from all paths (k, n, 2), best first."""
    table = scene.table
    if table is None:
        most = max(float(np.max(np.abs(paths))), extent_of(scene))
        far = 2.0 ** math.ceil(math.log2(_FAR * most))
        return [(far, far)]
    inside = np.arange(1, _GRID) / _GRID
    xs, ys = np.meshgrid(inside * table.length, inside * table.width)
    grid = np.stack([xs.ravel(), ys.ravel()], axis=1)
    nearest = np.full(len(grid), np.inf)
    for ball in range(paths.shape[1]):
        nearest = np.minimum(nearest, _distances(grid, paths[:-1, ball], paths[1:, ball]))
    order = np.argsort(-nearest, kind="stable")
    return [(float(x), float(y)) for x, y in grid[order[nearest[order] > clear]]]


def _distances(grid: FloatArray, starts: FloatArray, ends: FloatArray) -> FloatArray:
    """Return the distance of points (g, 2) from a path of straight lines (k, 2), (g,) [m]."""
    moves = np.any(ends != starts, axis=1)
    moves[0] = True  # a ball that never moves has a place, too
    starts, along = starts[moves], (ends - starts)[moves]
    squares = np.maximum(np.sum(along**2, axis=1), np.finfo(np.float64).tiny)
    nearest = np.full(len(grid), np.inf)
    for k in range(0, len(starts), _LINES):
        lines = slice(k, k + _LINES)
        away = grid[:, np.newaxis] - starts[lines]
        part = np.clip(np.sum(away * along[lines], axis=2) / squares[lines], 0.0, 1.0)
        away -= part[..., np.newaxis] * along[lines]
        nearest = np.minimum(nearest, np.min(np.hypot(away[..., 0], away[..., 1]), axis=1))
    return nearest


def _has_side_pockets(scene: Scene) -> bool:
    table = scene.table
    return table is not None and table.pockets is not None and table.pockets.side is not None


def _seen_from(scene: Scene, name: str, turn: FloatArray, *, exact: bool) -> RelatedShot:
    """Return a scene that is turned or mirrored, with the low corner of its table at (0, 0)."""
    table, shift = scene.table, np.zeros(3)
    if table is not None:
        corner = turn @ np.array([table.length, table.width, 0.0])
        shift = np.maximum(-corner, 0.0)
        table = table_from(table, turn, shift)
    balls = [moved(ball, turn=turn, shift=shift) for ball in scene.balls]
    made = _scene(scene, name, balls, table=table)
    return RelatedShot(made, exact, _in_order(balls), turn=turn, shift=shift)


def _scene(scene: Scene, relation: str, balls: Sequence[Ball], **changed: Any) -> Scene:
    fields = {"table": scene.table, "physics": scene.physics, "t_max": scene.t_max}
    return Scene(name=_name(scene, relation), balls=balls, **fields | changed)


def _name(scene: Scene, relation: str) -> str:
    return f"{scene.name[:_LONGEST_NAME]}.{relation}"


def _in_order(balls: Sequence[Ball]) -> tuple[int, ...]:
    return tuple(range(len(balls)))
