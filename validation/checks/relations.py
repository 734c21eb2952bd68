"""Relations that must hold between a shot and a second shot made from it.

Each relation is a metric. If a scene has a limit on this metric, the engine also simulates the
second shot. A relation needs no reference result. A relation that doesn't hold for this kind of
shot has no value.

`related_shots` makes the second shots, and `related_runs` compares them with the first. For each
relation, `NAME_factor` is the largest distance between the two runs in units of the distance that
the engine's own error explains. For relations that round nothing, `NAME_bits` counts the numbers
that differ in any bit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

import numpy as np

from ghostball.model import (
    EngineFailedError,
    Record,
    Result,
    Scene,
    SceneError,
    UnsupportedSceneError,
)
from ghostball.reference_adapters.base import ReferenceEngine
from ghostball.validation.checks.energy_curve import conserves_energy
from ghostball.validation.checks.metric import (
    Compute,
    MetricGroup,
    NotMeasuredError,
    RunAndTruth,
    RunIncompleteError,
)
from ghostball.validation.checks.related_runs import (
    Comparison,
    compare_runs,
    own_error,
    relative_error,
)
from ghostball.validation.checks.related_shots import SECOND_SHOTS, RelatedShot, mirror, split
from ghostball.validation.grading.tolerances import ROUNDINGS, UNIT_ROUNDOFF
from ghostball.validation.runs.engine_runs import run_engine, run_ours

RELATIONS: Final = MetricGroup()

RETURN_DISTANCE = 1e-3
"""Largest distance from the start that counts as a return, in radii of the smallest ball."""

WORDS: Final[Mapping[str, str]] = {
    "rotate": "the shot turned by 90 degrees (180 with side pockets)",
    "translate": "the shifted shot",
    "mirror": "the mirrored shot",
    "renumber": "the shot with its balls in reverse order",
    "scale": "the shot in units of twice the length and time",
    "boost": "the shot with a velocity added to all balls",
    "split": "the shot continued from its middle",
    "far-ball": "the shot with a further ball that nothing reaches",
}
"""The second shot of each relation in words, in the order of reports."""

ROUNDING_FREE: Final = ("mirror", "renumber", "scale", "far-ball")
"""Relations that may change no digit of any number of a scene."""


def factor_of(relation: str) -> str:
    """Return the name of the metric that compares the runs of a relation within errors."""
    return f"{relation.replace('-', '_')}_factor"


def bits_of(relation: str) -> str:
    """Return the name of the metric that compares the runs of a relation to the bit."""
    return f"{relation.replace('-', '_')}_bits"


def _engine_of(run: RunAndTruth) -> ReferenceEngine:
    """Return the engine that simulates the second shot."""
    if run.engine is None:
        raise NotMeasuredError("this metric needs an engine that simulates a second shot")
    run.require_end()
    return run.engine


def _compared(run: RunAndTruth, relation: str) -> tuple[RelatedShot, Comparison]:
    """Return the second shot of a relation and the comparison with the first, made once."""
    if relation not in run.related:
        engine = _engine_of(run)
        result = run.result
        if relation == "split":
            # in the part of the shot that is predictable, because nothing is compared later
            known = own_error(engine, result.scene, run.growth)
            related = split(result, math.inf if known is None else run.growth.horizon(known))
        else:
            related = SECOND_SHOTS[relation](result)
        second = _played(engine, related.scene, "trajectory")
        error = relative_error(engine, result, related, second, run.growth)
        compared = compare_runs(result, related, second, run.growth, error)
        run.related[relation] = related, compared
    found: tuple[RelatedShot, Comparison] = run.related[relation]
    return found


def _factor(relation: str) -> Compute:
    def compute(run: RunAndTruth) -> float:
        _, compared = _compared(run, relation)
        if compared.factor is None:
            raise NotMeasuredError(compared.words)
        run.said[factor_of(relation)] = compared.words
        return compared.factor

    return compute


def _bits(relation: str) -> Compute:
    def compute(run: RunAndTruth) -> int:
        related, compared = _compared(run, relation)
        if not related.exact:
            raise NotMeasuredError(
                "the second shot rounds numbers, or solves contacts in another order"
            )
        return compared.differing

    return compute


for _relation, _words in WORDS.items():
    RELATIONS.metric(
        factor_of(_relation),
        "1",
        f"largest distance between the shot and {_words}, in units of the distance that the "
        "engine's own error explains",
        on_demand=True,
    )(_factor(_relation))
for _relation in ROUNDING_FREE:
    RELATIONS.metric(
        bits_of(_relation),
        "1",
        f"positions and end that differ in any bit between the shot and {WORDS[_relation]}",
        on_demand=True,
    )(_bits(_relation))


@RELATIONS.metric(
    "mirror_error",
    "m",
    "largest distance between the mirrored final positions and those of the mirrored shot, with x "
    "and y swapped and the balls in reverse order",
    on_demand=True,
)
def _mirror_error(run: RunAndTruth) -> float:
    # In reverse order, to detect results that depend on the order of balls. An exact engine gives
    # bit-identical results in both cases.
    engine, result = _engine_of(run), run.result
    related = mirror(result)
    scene = related.scene.model_copy(update={"balls": related.scene.balls[::-1]})
    ends = _played(engine, scene).rest_positions[np.newaxis, ::-1]
    off = related.expected(np.array([result.rest_time]), ends)[0] - result.rest_positions
    return float(np.max(np.linalg.norm(off, axis=1)))


@RELATIONS.metric(
    "reversal_error",
    "m",
    "largest distance from the start after the shot is simulated backwards from its end, unless "
    "rounding alone prevents the return",
    on_demand=True,
)
def _reversal_error(run: RunAndTruth) -> float:
    return _way_back(run)[0]


@RELATIONS.metric(
    "reversal_factor",
    "1",
    "`reversal_error` in units of the error that one rounding per event would cause on the way "
    "back",
    on_demand=True,
)
def _reversal_factor(run: RunAndTruth) -> float:
    error, rounding = _way_back(run)
    return error / rounding


def _way_back(run: RunAndTruth) -> tuple[float, float]:
    """Return the largest distance from the start after the way back, and that of rounding [m].

    Each collision of two balls multiplies errors by about ten, so after some dozens of collisions
    per ball, rounding alone prevents the return. The tangent map of Ghostball's engine on the way
    back gives the size of this effect. Exact motion backwards would reduce errors of the way there
    to their original size; the way back adds errors of its own.
    """
    engine, result = _engine_of(run), run.result
    scene, turn = result.scene, result.rest_time
    if not conserves_energy(scene):
        raise NotMeasuredError("not applicable: energy is lost, so the reversed shot differs")
    if turn <= 0.0:
        raise NotMeasuredError("nothing moves")
    rounding = rounding_of_way_back(scene, turn)
    if ROUNDINGS * rounding > RETURN_DISTANCE * float(np.min(scene.radii)):
        raise NotMeasuredError("rounding alone keeps the reversed shot from returning to its start")
    try:
        back = scene_from_end(result, turn, -1.0)
    except SceneError as error:
        raise RunIncompleteError(f"its final state isn't a valid initial state: {error}") from error
    off = _played(engine, back).rest_positions - scene.positions
    return float(np.max(np.linalg.norm(off[:, :2], axis=1))), rounding


def rounding_of_way_back(scene: Scene, turn: float) -> float:
    """Return the distance from the start that rounding causes on the way back from a time [m].

    It is the rms effect of one rounding at each event, for the ball with the largest displacement,
    and at least one rounding of the largest coordinate.
    """
    there = run_ours(scene.model_copy(update={"t_max": turn}), "rest")
    back = run_ours(scene_from_end(there, turn, -1.0))
    least = float(np.max(np.abs(scene.positions)))
    return UNIT_ROUNDOFF * max(float(np.max(back.sensitivity([turn]))), least)


def scene_from_end(result: Result, t_max: float, sign: float = 1.0) -> Scene:
    """Return the scene that starts at the end of a run; with `sign` -1 it runs backwards.

    For balls that always roll without friction: their velocity determines their spin. All
    horizontal coordinates are copied to the bit.

    Raises `SceneError` if the final positions aren't valid initial positions.
    """
    positions, velocities, _ = (samples[0] for samples in result.final_state)
    balls = [
        ball.without_strike().model_copy(
            update={
                "position": (*r[:2], ball.radius),
                "velocity": (*v[:2], 0.0),
                "angular_velocity": None,
            }
        )
        for ball, r, v in zip(
            result.scene.balls, positions.tolist(), (sign * velocities + 0.0).tolist(), strict=True
        )
    ]
    scene = result.scene
    return Scene(
        name=scene.name, t_max=t_max, physics=scene.physics, table=scene.table, balls=tuple(balls)
    )


def _played(engine: ReferenceEngine, scene: Scene, record: Record = "rest") -> Result:
    """Simulate the second shot; an engine that doesn't finish it fails."""
    try:
        result = run_engine(engine, scene, record)
    except UnsupportedSceneError as error:
        raise NotMeasuredError(f"the engine doesn't support the second shot: {error}") from error
    except EngineFailedError as error:
        raise RunIncompleteError(f"in the second shot, {error}") from error
    if not result.status.complete:
        raise RunIncompleteError(f"the second shot stopped early ({result.status.value})")
    return result
