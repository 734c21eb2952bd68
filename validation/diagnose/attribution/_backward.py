"""Backward error: the change of the shot that an engine's outcome would be right for.

An engine that ends 3 mm off may have played the given shot badly, or a shot next to it well. The
smallest change of the cue ball's speed and direction with which the true shot ends as the engine's
did says which, in a player's words; what no such change explains is reported with it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import Ball, GhostballError, Scene
from ghostball.reference_adapters.certified import CertifiedSettings, certify
from ghostball.reference_adapters.certified.engine import result_of
from ghostball.validation.diagnose.attribution._zero_step import largest_distance
from ghostball.validation.runs.our_run import run_ours
from ghostball.validation.runs.rolling import rolling_spin
from ghostball.validation.truth.known_shot import KnownShot

FloatArray = NDArray[np.float64]
Shot = Callable[[FloatArray], FloatArray]
"""(relative change of speed, turn [rad]) -> centres (n, 2) [m]."""

CERTIFIED_EVENTS = 100
"""Events of a shot above which our engine plays its neighbours: certifying takes too long."""

DIFFERENCE_STEP = 1e-6
"""Step of the central differences, relative and in rad: their error is 1e-12 of the curvature."""

CONVERGED = 1e-13
"""Changes of speed, relative, and direction [rad] below which the search ends."""

MAX_ITERATIONS = 30
HALVINGS = 12
"""How often a step that makes it worse is halved before the search ends."""


class NoCueBallError(GhostballError):
    """A scene in which it can't be said which ball is the cue ball."""


class NotCertifiedError(GhostballError):
    """A shot next to a certified one can't be certified itself: nothing to compare with."""


@dataclass(frozen=True)
class BackwardError:
    """By how much an engine played another shot.

    Attributes
    ----------
    ball : str
        The cue ball, the fastest one at the start.
    speed : float [1]
        Relative change of its speed and spin; positive is harder.
    turn : float [rad]
        Change of its direction; positive is to the left.
    unexplained : float [m]
        Largest distance of a ball that is left with this change.
    iterations : int
    """

    ball: str
    speed: float
    turn: float
    unexplained: float
    iterations: int

    @property
    def degrees(self) -> float:
        """The turn in degrees."""
        return math.degrees(self.turn)


def cue_ball(scene: Scene) -> int:
    """Return the index of the cue ball: the fastest at the start.

    Raises
    ------
    NoCueBallError
        Where no ball moves, or several are the fastest.
    """
    speeds = np.array([ball.speed for ball in scene.balls])
    fastest = np.flatnonzero(speeds == speeds.max())
    if speeds.max() == 0.0:
        raise NoCueBallError(f'scene "{scene.name}": no ball moves at the start. Give one a speed')
    if len(fastest) > 1:
        names = ", ".join(f'"{scene.balls[i].id}"' for i in fastest)
        raise NoCueBallError(
            f'scene "{scene.name}": the cue ball is the fastest one, but {names} are equally fast '
            f"at {speeds.max():g} m/s"
        )
    return int(fastest[0])


def changed_shot(scene: Scene, ball: int, speed: float, turn: float) -> Scene:
    """Return the scene with a ball's velocity and spin scaled by 1 + `speed` and turned.

    Parameters
    ----------
    scene : Scene
    ball : int
    speed : float [1]
    turn : float [rad]
        About the vertical, to the left.
    """
    one = scene.balls[ball]
    factor, c, s = 1.0 + speed, math.cos(turn), math.sin(turn)
    rotation = factor * np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    v = rotation @ np.array(one.velocity)
    v[2] = one.velocity[2]
    changes: dict[str, object] = {"velocity": tuple(v.tolist())}
    if one.angular_velocity is not None:
        w = tuple((rotation @ np.array(one.angular_velocity)).tolist())
        changes["angular_velocity"] = (
            rolling_spin(v.tolist(), one.radius, w[2]) if scene.rolls[ball] else w
        )
    balls = list(scene.balls)
    balls[ball] = Ball(**{**dict(one), **changes})
    return Scene(**{**dict(scene), "balls": balls})


def backward_error(known: KnownShot, outcome: FloatArray, instant: float | None) -> BackwardError:
    """Return by how much an outcome is that of another shot.

    Parameters
    ----------
    known : KnownShot
        The true shot.
    outcome : (n, 2) float64 [m]
        Where the engine has the balls.
    instant : float or None [s]
        When; None is at rest, or at the scene's `t_max`.

    Raises
    ------
    NoCueBallError
        Where it isn't clear which ball was played.

    Notes
    -----
    Least squares over all coordinates of all balls by Gauss and Newton: the true shot is certified
    where that is quick, its derivative is by central differences of our engine. A step that
    doesn't make it better is halved; where no part of it does, the search has ended.
    """
    scene = known.scene
    ball = cue_ball(scene)

    def change(x: FloatArray) -> Scene:
        changed = changed_shot(scene, ball, float(x[0]), float(x[1]))
        return changed if instant is None else changed.model_copy(update={"t_max": instant})

    def ours(x: FloatArray) -> FloatArray:
        return run_ours(change(x), "rest").rest_positions[:, :2]

    proves = known.kind == "certified" and known.result.work["events"] <= CERTIFIED_EVENTS
    shot: Shot = (lambda x: _certified(change(x))) if proves else ours
    x, iterations = _least_squares(shot, ours, outcome)
    return BackwardError(
        ball=scene.balls[ball].id,
        speed=float(x[0]),
        turn=float(x[1]),
        unexplained=largest_distance(shot(x), outcome),
        iterations=iterations,
    )


def _certified(scene: Scene) -> FloatArray:
    # Not kept on disk: nobody asks for these shots again.
    settings = CertifiedSettings()
    result = result_of(scene, certify(scene, cached=False), settings, "rest")
    if not result.status.complete:
        raise NotCertifiedError(
            f'scene "{scene.name}": a shot next to it can\'t be certified: {result.reason}'
        )
    return result.rest_positions[:, :2]


def _least_squares(shot: Shot, model: Shot, outcome: FloatArray) -> tuple[FloatArray, int]:
    """Return the change (2,) that brings `shot` nearest to `outcome`, and how many steps it took.

    `model` is what is differentiated.
    """
    x = np.zeros(2)
    left = (shot(x) - outcome).ravel()
    for iteration in range(MAX_ITERATIONS):
        step, *_ = np.linalg.lstsq(_jacobian(model, x), -left, rcond=1e-10)
        for _ in range(HALVINGS):
            if float(np.abs(step).max()) < CONVERGED:
                return x, iteration
            tried = (shot(x + step) - outcome).ravel()
            if tried @ tried < left @ left:
                break
            step = 0.5 * step
        else:
            return x, iteration
        x, left = x + step, tried
    return x, MAX_ITERATIONS


def _jacobian(model: Shot, x: FloatArray) -> FloatArray:
    """Return the derivative of `model`, (2 n, 2), by central differences."""
    columns = []
    for k in range(len(x)):
        h = np.zeros_like(x)
        h[k] = DIFFERENCE_STEP
        columns.append((model(x + h) - model(x - h)).ravel() / (2.0 * DIFFERENCE_STEP))
    return np.column_stack(columns)
