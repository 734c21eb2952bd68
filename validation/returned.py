"""Whether what an engine handed back can be measured: anyone's engine joins, so it is looked at."""

from __future__ import annotations

import math

import numpy as np

from engine import GhostballError, Result, Scene

_MEND = "Mend `simulate` of engine `{engine}`; `ReferenceEngine` says what it must return"


class ResultRefusedError(GhostballError):
    """A result that breaks the contract of `Result`: no number of it may be judged."""


def check_result(result: Result, scene: Scene, engine: str) -> None:
    """Make sure that a result is one of this scene on this engine, with an end to measure.

    Parameters
    ----------
    result : Result
        What the engine returned.
    scene : Scene
        What it was asked to run.
    engine : str
        Its name.

    Raises
    ------
    ResultRefusedError
        Where it is no `Result`, names another engine or scene, or its end is not finite.
    """
    problem = _problem(result, scene, engine)
    if problem:
        said = getattr(result, "reason", "")
        because = f" (the engine says: {said})" if said else ""
        raise ResultRefusedError(f"{problem}{because}. {_MEND.format(engine=engine)}")


def _problem(result: object, scene: Scene, engine: str) -> str:
    """Return the first rule that is broken, with the value received; "" where none is."""
    if not isinstance(result, Result):
        return f"`simulate` must return a `Result`, got {type(result).__name__}"
    if result.engine != engine:
        return f"`engine` of the result must be {engine!r}, got {result.engine!r}"
    if result.scene is not scene and result.scene != scene:
        return (
            f'`scene` of the result must be the scene that was run, "{scene.name}", got another '
            f"one, {getattr(result.scene, 'name', result.scene)!r}"
        )
    if not math.isfinite(result.rest_time) or result.rest_time < 0.0:
        return f"`rest_time` must be finite and at least 0 s, got {result.rest_time}"
    positions = np.asarray(result.rest_positions)
    wanted = (len(scene.balls), 3)
    if positions.shape != wanted:
        return f"`rest_positions` must have shape {wanted}, got {positions.shape}"
    lost = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if len(lost):
        ball = int(lost[0])
        return (
            f"`rest_positions[{ball}]` must be finite, got {positions[ball].tolist()} "
            f'for ball "{scene.balls[ball].id}"'
        )
    return ""
