"""The rules about initial motion: limits on spin, deceleration, and duration of the shot."""

from __future__ import annotations

import numpy as np

from ghostball.model.arrays import FloatArray
from ghostball.model.scene.contents import SceneContents
from ghostball.model.scene.fields import (
    LARGEST,
    MAX_DRAG_RATE,
    MAX_FALL_DRAG,
    MAX_IMPACTS,
    SMALLEST,
    problem,
)
from ghostball.model.scene.initial_states import InitialStates


def check_motions(scene: SceneContents, starts: InitialStates) -> None:
    """Check the initial motion of the balls of a scene.

    Raises `PydanticCustomError` for the first rule that a scene with one of these states would
    break.
    """
    _check_rolling(scene, starts)
    _check_spin(starts)
    _check_drag(scene, starts)
    _check_ends(scene, starts)


def _check_rolling(scene: SceneContents, starts: InitialStates) -> None:
    if scene.physics.motion != "rolling":
        return
    spin, rolling = starts.spin, starts.rolling
    scale = np.max(np.abs(np.hstack((rolling, spin))), axis=1, keepdims=True)
    for k in np.flatnonzero(np.any(np.abs(spin - rolling) > 1e-9 * scale, axis=1))[:1]:
        if scene.balls[starts.ball[k]].strike is not None and starts.shot is None:
            raise starts.problem(
                k,
                "strike",
                'must make the ball roll without slip if `motion` = "rolling": level, without '
                'side, with `offset_up` = 0.4 and `squirt` = "none". It gives '
                f"{tuple(spin[k].tolist())} rad/s instead of {tuple(rolling[k].tolist())}. Change "
                'the strike, or set `motion` = "sliding"',
            )
        raise starts.problem(
            k,
            "angular_velocity",
            f"must equal {tuple(rolling[k].tolist())}, rolling without slip, because `motion` = "
            f'"rolling"; got {tuple(spin[k].tolist())}. Remove it, or set `motion` = "sliding"',
        )


def _check_spin(starts: InitialStates) -> None:
    surface = np.where(starts.given, starts.radius * _size(starts.spin), 0.0)
    for k in np.flatnonzero(surface > LARGEST)[:1]:
        raise starts.problem(
            k,
            "angular_velocity",
            f"must give a surface speed of at most {LARGEST:g} m/s, got "
            f"{tuple(starts.spin[k].tolist())} rad/s, which gives {surface[k]:g} m/s",
        )


def _size(vectors: FloatArray) -> FloatArray:
    """Return the lengths of vectors (m, 2) or (m, 3); squares of tiny numbers don't underflow."""
    sizes: FloatArray = np.hypot.reduce(vectors, axis=1)
    return sizes


def _speeds(starts: InitialStates) -> FloatArray:
    """Return the larger of each ball's speed and the speed of its surface [m/s]."""
    surface = starts.radius * _size(starts.spin[:, :2])
    return np.maximum(_size(starts.velocity), surface)


def _check_drag(scene: SceneContents, starts: InitialStates) -> None:
    """Reject decelerations so large that the motion can't be computed."""
    speeds, physics = _speeds(starts), scene.physics
    k = int(np.argmax(speeds))
    for field in ("air_drag", "rolling_friction_quadratic"):
        drag: float = getattr(physics, field)
        if drag * float(speeds[k]) > MAX_DRAG_RATE:
            raise problem(
                f"`physics.{field}` times the speed of a ball must be at most {MAX_DRAG_RATE:g} "
                f"per second, got {drag:g} 1/m times the {speeds[k]:g} m/s of {starts.name(k)}: "
                "its motion would exceed the range of doubles. Lower one of them",
                at=("physics", field),
            )
    if physics.airborne and physics.air_drag * physics.gravity > MAX_FALL_DRAG:
        raise problem(
            f"`physics.air_drag` times `physics.gravity` must be at most {MAX_FALL_DRAG:g} per "
            f"second squared if `airborne` = true, got {physics.air_drag:g} 1/m times "
            f"{physics.gravity:g} m/s^2: a fall would exceed the range of doubles. Lower one of "
            "them",
            at=("physics", "air_drag"),
        )


def _check_ends(scene: SceneContents, starts: InitialStates) -> None:
    """Reject a shot without `t_max` that might never end, or only after a very long time."""
    # A moving ball may set any other ball in motion, so every speed is compared with every
    # friction.
    if scene.t_max is not None:
        return
    rolls = ("roll", "rolling_friction", scene.rolling_frictions)
    slides = ("slide", "sliding_friction", scene.sliding_frictions)
    sliding = scene.physics.motion == "sliding"
    speeds = _speeds(starts)
    if scene.physics.airborne and scene.physics.table_restitution == 1.0:
        raise problem(
            "`t_max` must be given if `table_restitution` is 1: a bouncing ball might never come "
            "to rest. Set `t_max` to a time in seconds",
            at=("physics", "table_restitution"),
        )
    for verb, field, frictions in (rolls, slides) if sliding else (rolls,):
        _check_stops(scene, starts, speeds, verb, field, frictions)
    if sliding:
        _check_spin_ends(scene, starts, speeds)
    _check_impacts_end(scene, starts)


def _check_impacts_end(scene: SceneContents, starts: InitialStates) -> None:
    # If only rolling dissipates energy, the total distance that the balls roll follows from the
    # energy. On a closed table, no straight path is longer than the diagonal.
    physics, table = scene.physics, scene.table
    elastic = physics.cushion == "mirror" and physics.ball_restitution == 1.0
    drag = physics.air_drag + physics.rolling_friction_quadratic
    if table is None or len(table.cushions) < 4 or not elastic or drag > 0.0:
        return
    if physics.motion != "rolling" or physics.airborne:
        return
    speeds, masses = _size(starts.velocity), scene.masses[starts.ball]
    slowing = float(np.max(scene.masses * scene.rolling_frictions)) * physics.gravity
    ways = 0.5 * masses * speeds**2 / max(slowing, SMALLEST)
    k = int(np.argmax(ways))
    impacts = float(ways[k]) / float(np.hypot(table.length, table.width)) - len(scene.balls)
    if impacts > MAX_IMPACTS:
        raise problem(
            f"`t_max` must be given if balls would hit cushions more than {MAX_IMPACTS:g} "
            f"times before they rest: {starts.name(k)} starts at {speeds[k]:g} m/s and needs at "
            f"least {impacts:.2g} collisions to come to rest. Set `t_max` to a time in seconds, "
            "or slow the ball",
            at=("balls", int(starts.ball[k]), "velocity"),
        )


def _check_stops(
    scene: SceneContents,
    starts: InitialStates,
    speeds: FloatArray,
    verb: str,
    field: str,
    frictions: FloatArray,
) -> None:
    k, j = int(np.argmax(speeds)), int(np.argmin(frictions))
    # The same product as in the engine: for two tiny factors it may round to 0.
    deceleration = float(frictions[j]) * scene.physics.gravity
    if deceleration == 0.0 and speeds[k] > 0.0:
        raise problem(
            f"`t_max` must be given if a ball moves ({starts.name(k)}) and a ball loses no speed "
            f"while it {verb}s (`balls[{j}]`, `{field}` = {float(frictions[j])}): it might never "
            "come to rest. Set `t_max` to a time in seconds",
            at=("balls", int(starts.ball[k])),
        )
    if speeds[k] > LARGEST * deceleration:
        raise problem(
            f"`t_max` must be given if a ball with the speed of {starts.name(k)}, "
            f"{speeds[k]:g} m/s, would {verb} for more than {LARGEST:g} s: `balls[{j}]` loses "
            f"{deceleration:g} m/s each second. Set `t_max` to a time in seconds",
            at=("balls", int(starts.ball[k])),
        )


def _check_spin_ends(scene: SceneContents, starts: InitialStates, speeds: FloatArray) -> None:
    # Friction in an impact may also turn speed into vertical spin. Spin that doesn't decay doesn't
    # prolong the run.
    rates = scene.spinning_friction_rates
    if not np.any(rates > 0.0):
        return
    vertical = starts.radius * np.abs(starts.spin[:, 2])
    spin = float(max(np.max(vertical), np.max(speeds))) / float(np.min(scene.radii))
    j = int(np.argmin(np.where(rates > 0.0, rates, np.inf)))
    if spin > LARGEST * float(rates[j]):
        raise problem(
            f"`t_max` must be given if a ball might spin for more than {LARGEST:g} s: it may "
            f"have {spin:g} rad/s, and `balls[{j}]` loses {rates[j]:g} rad/s each second. Set "
            "`t_max` to a time in seconds",
            at=("balls", j),
        )
