"""Simulation of one scene from many initial states of its balls."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic_core import PydanticCustomError

from ghostball.engine.batch import Batch, batch_of, workers_of
from ghostball.engine.running.calls import Limits, Shots, shots_of
from ghostball.engine.running.from_scene import layout_of
from ghostball.engine.running.threads import rows_of_starts, run_tasks, tasks_of
from ghostball.engine.shot import MAX_EVENTS, MAX_WORK, check_request
from ghostball.engine.strokes import DrawnStrokes, Strokes
from ghostball.model import Scene, rolling_angular_velocity
from ghostball.model.errors import GhostballError
from ghostball.model.scene.fields import LARGEST
from ghostball.model.scene.initial_states import InitialStates, struck_motions
from ghostball.model.scene.messages import refusal
from ghostball.model.scene.motion_rules import check_motions
from ghostball.model.scene.rules import check_places

_BALLS_PER_CHUNK = 2**18
"""Number of balls whose initial states are checked or laid out at a time: about ten megabytes."""


class Given(NamedTuple):
    """Initial states of m balls in each of k shots, (k, m, 3); other balls start as in the scene.

    The m balls are consecutive, and the first of them is ball `who`.
    """

    who: int
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64]
    spins: NDArray[np.float64] | None  # None if all balls roll
    given: NDArray[np.bool_]  # (m,) whether the spin of a ball is given

    @property
    def balls(self) -> NDArray[np.int64]:
        """The indices of the balls in the scene, (m,)."""
        return np.arange(self.who, self.who + len(self.given))

    def part(self, shots: slice) -> Given:
        """Return the initial states of some of the shots."""
        spins = None if self.spins is None else self.spins[shots]
        return self._replace(
            positions=self.positions[shots], velocities=self.velocities[shots], spins=spins
        )

    def rolling_and_spins(self, scene: Scene) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the spins of rolling, and the initial spins, (k, m, 3) [rad/s]."""
        rolling = rolling_angular_velocity(self.velocities, scene.radii[self.balls])
        if self.spins is None:
            return rolling, rolling
        return rolling, np.where(self.given[:, None], self.spins, rolling)


def simulate_starts(
    scene: Scene,
    positions: ArrayLike | None = None,
    velocities: ArrayLike | None = None,
    angular_velocities: ArrayLike | None = None,
    *,
    strokes: Strokes | None = None,
    threads: int | None = None,
    max_events: int = MAX_EVENTS,
    max_work: int = MAX_WORK,
) -> Batch:
    """Simulate one scene from each of k initial states, with the same table and physics.

    Parameters
    ----------
    scene : Scene
        With n balls.
    positions : (k, n, 2 or 3) float64 [m], or (n, 2 or 3) for all shots
        Centres; without a height, balls lie on the cloth. None: those of the scene.
    velocities : (k, n, 2 or 3) float64 [m/s], or (n, 2 or 3) for all shots
        Of the centres; without z, z is 0. None: those of the scene.
    angular_velocities : (k, n, 3) float64 [rad/s], or (n, 3) for all shots
        None: if `velocities` are given, those of rolling without slip; otherwise those of the
        scene.
    strokes : Strokes, optional
        The strokes of a cue at one ball, instead of its motion in the scene; `velocities` and
        `angular_velocities` must then be None.
    threads, max_events, max_work
        As for `simulate_many`.

    Returns
    -------
    Batch
        Bit-identical to `simulate` with such scenes, but faster, because no scene is built.

    Raises
    ------
    UnsupportedSceneError, GhostballError
        If the scene, or an argument, is invalid.
    SceneError
        If a scene with one of these initial states would be invalid; before anything is simulated.
    """
    workers = workers_of(threads)
    check_request(scene, "rest", max_events, max_work)
    drawn = None
    if strokes is None:
        given = _given(scene, positions, velocities, angular_velocities)
    elif not isinstance(strokes, Strokes):
        raise GhostballError(
            f"`strokes` must be Strokes, got {type(strokes).__name__}. Give "
            "Strokes(speed=..., direction=...)"
        )
    elif velocities is not None or angular_velocities is not None:
        raise GhostballError(
            "`velocities` and `angular_velocities` must not be given with `strokes`: the cue sets "
            "the ball in motion. Remove them, or the strokes"
        )
    else:
        given, drawn = _struck(scene, positions, strokes)
    return play_starts(scene, given, Limits(max_events, max_work), workers, drawn)


def play_starts(
    scene: Scene,
    given: Given,
    limits: Limits,
    threads: int,
    strokes: DrawnStrokes | None = None,
) -> Batch:
    """Simulate a scene from each of k initial states, after checking all of them.

    `strokes`: those that give the initial states, for the batch.

    Raises `SceneError` if a scene with one of these initial states would be invalid.
    """
    k, m = given.positions.shape[:2]
    size = max(1, _BALLS_PER_CHUNK // m)
    parts = [slice(first, min(first + size, k)) for first in range(0, k, size)]
    with ThreadPoolExecutor(threads) as pool:
        for _ in pool.map(lambda part: _check(scene, given.part(part), part.start), parts):
            pass
    layout, shots = layout_of(scene), shots_of(k, len(scene.balls), 1)
    for part in parts:
        those = given.part(part)
        _, spins = those.rolling_and_spins(scene)
        starts = rows_of_starts(
            scene, given.balls, those.positions, those.velocities, spins, given.given
        )
        of_part = Shots(starts, shots.clocks[part], shots.counts[part], shots.ends[part])
        shares = tasks_of(layout, len(starts), threads)
        run_tasks(shares, of_part, limits, threads, who=given.who)
    return batch_of(shots, layout.smallest_radius, (scene,), strokes)


def _given(
    scene: Scene,
    positions: ArrayLike | None,
    velocities: ArrayLike | None,
    spins: ArrayLike | None,
) -> Given:
    """Return the initial states of all shots."""
    n = len(scene.balls)
    turned = np.array([ball.angular_velocity is not None for ball in scene.balls])
    if spins is not None or velocities is not None:
        turned = np.full(n, spins is not None)
    elif np.any(turned):
        spins = scene.angular_velocities
    arrays = [
        _array("positions", scene.positions if positions is None else positions, n, (2, 3)),
        _array("velocities", scene.velocities if velocities is None else velocities, n, (2, 3)),
    ]
    if spins is not None:
        arrays.append(_array("angular_velocities", spins, n, (3,)))
    counts = {len(array) for array in arrays if array.ndim == 3}
    if len(counts) > 1:
        raise GhostballError(
            "`positions`, `velocities` and `angular_velocities` must be of equally many shots, "
            f"got {' and '.join(str(count) for count in sorted(counts))}"
        )
    k = counts.pop() if counts else 1
    whole = [np.broadcast_to(array, (k, n, array.shape[-1])) for array in arrays]
    for index, above in ((0, scene.radii), (1, np.zeros(n))):
        if whole[index].shape[2] == 2:
            heights = np.broadcast_to(above[None, :, None], (k, n, 1))
            whole[index] = np.concatenate((whole[index], heights), axis=2)
    return Given(0, whole[0], whole[1], whole[2] if len(whole) > 2 else None, turned)


def _struck(
    scene: Scene, positions: ArrayLike | None, strokes: Strokes
) -> tuple[Given, DrawnStrokes]:
    """Return the initial states of all shots of a ball that is struck, and the strokes."""
    base = _given(scene, positions, None, None)
    drawn = strokes.drawn(scene, len(base.positions))
    who, k, radius = drawn.ball, len(drawn.speed), scene.balls[drawn.ball].radius
    velocity, spin = struck_motions(scene, who, drawn.cue, drawn.aims)
    heights = base.positions[:, who, 2]
    for j in np.flatnonzero(heights != radius)[:1]:
        raise refusal(
            f"`balls[{who}].position` in shot {j} must have z = {radius} m, the radius, because a "
            f"ball with a stroke must lie on the cloth; got {heights[j]} m. Remove z"
        )
    if positions is None:  # only the motion of this ball differs from the scene
        place = np.broadcast_to(base.positions[:, who, None], (k, 1, 3))
        return Given(who, place, velocity[:, None], spin[:, None], np.ones(1, np.bool_)), drawn
    shape = (k, len(scene.balls), 3)
    velocities = np.broadcast_to(base.velocities, shape).copy()
    spins = np.zeros(shape) if base.spins is None else np.broadcast_to(base.spins, shape).copy()
    velocities[:, who], spins[:, who] = velocity, spin
    given = base.given.copy()
    given[who] = True
    return Given(0, np.broadcast_to(base.positions, shape), velocities, spins, given), drawn


def _array(
    name: str, values: ArrayLike, n: int, components: tuple[int, ...]
) -> NDArray[np.float64]:
    """Return an argument as an array (k, n, c) or (n, c); its numbers are checked later."""
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise GhostballError(f"`{name}` must be an array of numbers") from None
    if array.ndim not in (2, 3) or array.shape[-2] != n or array.shape[-1] not in components:
        number = " or ".join(map(str, components))
        raise GhostballError(
            f"`{name}` must have the shape (shots, {n}, {number}), or ({n}, {number}) for all "
            f"shots, as the scene has {n} balls; got {array.shape}"
        )
    return array


def _check(scene: Scene, given: Given, first: int) -> None:
    """Raise if a scene with these initial states would be invalid; the first is shot `first`.

    This checks the range of single numbers; the rules of scenes check the rest.
    """
    k, m = given.positions.shape[:2]
    with np.errstate(over="ignore", invalid="ignore"):  # infinite numbers are rejected below
        rolling, spins = given.rolling_and_spins(scene)
    everyone = np.ones(m, dtype=np.bool_)
    for name, vectors, asked in (
        ("position", given.positions, everyone),
        ("velocity", given.velocities, everyone),
        ("angular_velocity", spins, given.given),
    ):
        # The comparison is written so that NaN is rejected, too.
        for j, i, c in np.argwhere(~(np.abs(vectors) <= LARGEST) & asked[:, None])[:1]:
            raise refusal(
                f"`balls[{given.who + i}].{name}` in shot {first + j} must be finite and at most "
                f"{LARGEST:g} in size, got {vectors[j, i, c]}"
            )
    starts = InitialStates(
        np.tile(given.balls, k),
        np.tile(scene.radii[given.balls], k),
        given.positions.reshape(-1, 3),
        given.velocities.reshape(-1, 3),
        spins.reshape(-1, 3),
        rolling.reshape(-1, 3),
        np.tile(given.given, k),
        np.arange(first, first + k).repeat(m),
    )
    try:
        if m == len(scene.balls):  # if not, the positions are those of the scene
            check_places(scene, starts)
        check_motions(scene, starts)
    except PydanticCustomError as error:
        raise refusal(error.message()) from None
