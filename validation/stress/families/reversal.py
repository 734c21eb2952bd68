"""Time reversal: elastic play without friction, turned round after k collisions, comes back.

Each collision of round balls makes errors grow some tenfold, so that after some dozens for each
ball not even rounding leads back. When, the tangent map of our own motion back says: 2^-53 times
`Result.sensitivity` is what rounding the state once at each event makes of the end. What the way
forth got wrong, exact motion would bring back unharmed; the way back makes errors of its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from ghostball.model import (
    POOL_BALL_RADIUS as RADIUS,
    Ball,
    GhostballError,
    Result,
    Scene,
    SceneError,
    Table,
)
from ghostball.reference_adapters import ReferenceEngine
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.grading.tolerances import ROUNDINGS, UNIT_ROUNDOFF
from ghostball.validation.runs.playing import run_ours
from ghostball.validation.stress.gas import ICE, begun_at_end, gas
from ghostball.validation.stress.trial import Family, Suite, Trial, Verdict, play

TOLERANCE = 1e-3 * RADIUS
"""Distance from the start up to which balls have come back [m]."""

FACTOR = ROUNDINGS
"""How many times the prediction our engine's error may be, and it may outdo it by as much: some
roundings at each event instead of one, and cancellation. In collisions that is little, for errors
grow with them by powers."""

CHANCES = 2
"""How often in a row our engine may come back where the prediction over `FACTOR` is beyond the
tolerance. The prediction is a root mean square, and the error one draw, in the one direction that
grows most: one in forty draws is that small by chance, two in a row are one in 1600."""

GROWTH = 1.2
"""From one number of collisions to the next, where small ones don't make it 1."""


class Step(NamedTuple):
    """There and back by k collisions: when it turned [s], the prediction and the distance [m]."""

    k: int
    turn: float
    predicted: float
    distance: float


@dataclass(frozen=True)
class ReversalTrial(Trial):
    """One scene, turned round after 1, 2 ... collisions.

    `scene`: elastic, without friction; with a `t_max` by which there are `most` collisions.
    `most`, `stepped`: collisions after which to turn round at the latest: for our engine, and for
        any other.
    """

    name: str
    scene: Scene
    most: int
    stepped: int

    limit: ClassVar[float] = 120.0

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Go there and back, ever farther, until rounding must have lost the way."""
        steps: list[Step] = []
        for k, turn in self._turns(self.most if engine.name == OURS else self.stepped):
            there = until(self.scene, turn)
            predicted = prediction(there)
            distance = there_and_back(engine, there)
            if isinstance(distance, Verdict):
                return distance
            steps.append(Step(k, turn, predicted, distance))
            if is_hopeless(steps[-1]) and not distance <= TOLERANCE:
                break
            if longest_luck(steps) >= CHANCES:
                break
            if engine.name != OURS and distance > TOLERANCE:
                break
        return judge(self.scene, steps, engine.name == OURS)

    def _turns(self, most: int) -> Iterator[tuple[int, float]]:
        """Yield numbers of collisions, and an instant between the last of them and the next [s]."""
        events = run_ours(self.scene, "events").events
        assert events is not None
        times = np.append(events["t"], math.inf)
        k = 1
        while k < len(times) - 1 and k <= most:
            if times[k - 1] < times[k] < math.inf:
                yield k, 0.5 * float(times[k - 1] + times[k])
            k = max(k + 1, round(GROWTH * k))


def until(scene: Scene, turn: float) -> Scene:
    """Return the scene that ends at an instant."""
    return scene.model_copy(update={"t_max": turn})


def prediction(there: Scene) -> float:
    """Return how far from the start rounding leaves the balls, at one of each event's state [m].

    The root mean square, of the ball that it displaces most.
    """
    turn = there.t_max
    assert turn is not None
    back = run_ours(begun_at_end(run_ours(there, "rest"), turn, -1.0))
    return UNIT_ROUNDOFF * float(np.max(back.sensitivity([turn])))


def there_and_back(engine: ReferenceEngine, there: Scene) -> float | Verdict:
    """Return how far from its start the ball is that comes back worst [m]."""
    turned = play(engine, there, "rest")
    if isinstance(turned, Verdict):
        return turned
    assert there.t_max is not None
    try:
        scene = begun_at_end(turned, there.t_max, -1.0)
    except SceneError as error:
        return Verdict.of(there, [f"where it ends at {there.t_max:.6g} s no shot begins: {error}"])
    result: Result | Verdict = play(engine, scene, "rest")
    if isinstance(result, Verdict):
        return result
    off = result.rest_positions[:, :2] - there.positions[:, :2]
    return float(np.max(np.hypot(*off.T)))


def judge(scene: Scene, steps: list[Step], ours: bool) -> Verdict:
    """Judge how far the ways back led, in order of k.

    Asked of any engine: it comes back as long as `FACTOR` times the prediction is within the
    tolerance. Of ours also that its error is within `FACTOR` of the prediction, and that it is lost
    where even the prediction over `FACTOR` is beyond the tolerance, but for `CHANCES`: or the
    prediction would say nothing.

    Raises `GhostballError` where it is asked of no step that the balls come back, so that nothing
    would be judged.
    """
    sure = [step for step in steps if FACTOR * step.predicted <= TOLERANCE]
    if not sure:
        raise GhostballError(
            f"scene {scene.name!r} has no collision after which rounding leads back"
        )
    lost = [step for step in steps if not step.distance <= TOLERANCE]
    faults = []
    for step in [step for step in sure if step in lost][:1]:
        faults.append(
            f"it isn't back after {step.k} collisions, but {step.distance:.3g} m off; rounding "
            f"alone leads back to {step.predicted:.3g} m"
        )
    nearest = max((step.distance / TOLERANCE for step in sure), default=0.0)
    if ours:
        ratios = [step.distance / (FACTOR * step.predicted) for step in sure if step.predicted]
        nearest = max(ratios, default=0.0)
        worst = next((s for s in sure if not s.distance <= FACTOR * s.predicted), None)
        if worst is not None:
            faults.append(
                f"after {worst.k} collisions it comes back to {worst.distance:.3g} m, "
                f"{worst.distance / worst.predicted:.3g} times what rounding makes of it"
            )
        if longest_luck(steps) >= CHANCES:
            k, _, predicted, _ = next(s for s in reversed(steps) if is_hopeless(s))
            faults.append(
                f"it still comes back after {k} collisions, where rounding is predicted to lead "
                f"{predicted:.3g} m astray: the prediction is wrong"
            )
    expected = next((step.k for step in steps if step.predicted > TOLERANCE), None)
    values = {
        "lost_after": lost[0].k if lost else None,
        "predicted": expected,
    }
    shown = until(scene, lost[0].turn) if lost else scene
    return Verdict.of(shown, faults, nearest, values)


def is_hopeless(step: Step) -> bool:
    """Whether even the prediction over `FACTOR` is beyond the tolerance."""
    return step.predicted > FACTOR * TOLERANCE


def longest_luck(steps: list[Step]) -> int:
    """Return after how many hopeless steps in a row the balls came back, at most."""
    longest = row = 0
    for step in steps:
        row = row + 1 if is_hopeless(step) and step.distance <= TOLERANCE else 0
        longest = max(longest, row)
    return longest


def _line(most: int) -> Scene:
    """Return three balls on a line across two cushions: no error grows by powers there."""
    return Scene(
        name="line",
        t_max=0.1 * most,
        physics=ICE,
        table=Table(length=1.0, width=1.0, cushions=("left", "right")),
        balls=[
            Ball(id="a", position=(0.2, 0.5), velocity=(1.0, 0.0), mass=1.0),
            Ball(id="b", position=(0.5, 0.5), velocity=(-0.3, 0.0), mass=2.5),
            Ball(id="c", position=(0.8, 0.5), velocity=(0.7, 0.0), mass=0.7),
        ],
    )


def _unlike(scene: Scene) -> Scene:
    """Return the gas with balls of different sizes and masses."""
    balls = tuple(
        Ball(
            id=ball.id,
            position=ball.position[:2],
            velocity=ball.velocity[:2],
            radius=RADIUS * (0.5 + 0.25 * (i % 3)),
            mass=1.0 + 0.7 * (i % 4),
        )
        for i, ball in enumerate(scene.balls)
    )
    return Scene(name=scene.name, t_max=scene.t_max, physics=ICE, table=scene.table, balls=balls)


def _trials(suite: Suite) -> Iterator[Trial]:
    full = suite == "full"
    stepped = 100 if full else 8
    for rows in (2, 3, 4, 6, 10) if full else (3,):
        for packing in (0.1, 0.4) if full else (0.2,):
            for seed in (1, 2) if full else (1,):
                scene = gas(rows, packing, 6.0 / packing**0.5, seed)
                yield ReversalTrial(
                    f"gas-{rows**2}-{packing:g}-{seed}", scene, 100 * rows**2, stepped
                )
    if full:
        yield ReversalTrial("unlike-16", _unlike(gas(4, 0.3, 20.0)), 1600, stepped)
    most = 10_000 if full else 100
    yield ReversalTrial(f"line-{most}", _line(most), most, stepped)


FAMILY = Family(
    "reversal",
    "Time reversal",
    "Elastic play without friction, turned round after k collisions, is back at its start within "
    "a thousandth of a radius, for every k for which rounding, as the tangent map carries it on, "
    "leaves 32 times that; our engine's error is within 32 times that prediction, and it is lost "
    "where the prediction is beyond the tolerance by as much.",
    _trials,
)
