"""Energy that a run gains although nothing in its scene can supply energy.

Cloth, cushions and impacts only dissipate energy. An energy gain in an impact is small compared
with the loss on the cloth between two samples of the motion, so samples must be close to the
impact. An exact motion is sampled just before each event and at the event. A time-stepping engine
is known only at its frames: if balls collide between two frames, the loss on the cloth in that time
is added to the difference, because it would hide a gain.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ghostball.model import (
    COLLISION_KINDS,
    Result,
    SampledTrajectory,
    Samples,
    Scene,
    energy_of,
    first_energy,
)
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.base import Resolution, resolution_of_step, stated_error
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.grading.tolerances import EPS, MOST_CONTACT_STEPS, contact_error
from ghostball.validation.runs.sampling import (
    energy_series,
    energy_times,
    events_of,
    free_frames,
)

_ROLLING_SLIP = 1e-12
"""Slip of a rolling ball that counts as rounding, in units of its speed."""

_VERTICAL_ROUNDING = 1e-12
"""Vertical speed of a ball on the cloth that counts as rounding, in units of its speed."""

_ROUNDINGS_SEEN = 4.0
"""Roundings of a time, or of a height, that don't count as a gain."""

_SURFACE_SPEEDS = 1.0 + math.sqrt(2.5)
"""Largest sum of m (v + R w) over all balls, in units of sqrt(2 E sum m); see `_rounding`."""

TINY = float(np.finfo(np.float64).tiny)
"""Least value for the speed of a scene at rest [m/s], to avoid a division by zero."""


def largest_gain(result: Result, resolution: Resolution = 0.0, *, pressed: bool = False) -> float:
    """Return the largest energy gain of a run [J]; 0 if there is none, NaN if energy isn't finite.

    It is the largest rise above an earlier minimum. For a time-stepping engine, it is also the
    largest gain in a time step with a collision.

    `resolution` [m]: position error that the engine states for balls at a collision:
        `resolution_of`.

    An engine that detects contacts late uses old velocities for the collision: Chipmunk uses the
    velocities from before the time step, and thus returns the energy that the cloth dissipated in
    it. A gain up to the loss on the cloth while the fastest ball moves by `resolution` is therefore
    not counted. Rounding errors of heights and times in an exact motion, and the errors of contact
    steps, aren't counted either.

    `pressed`: whether the shot has resting contacts; used for engines that don't count their
        contact steps.
    """
    energy, frames = energy_series(result), free_frames(result)
    if frames is None:
        rounding = _rounding(result.scene, energy_times(result), energy)
        steps = MOST_CONTACT_STEPS if pressed else 0
        if result.engine == OURS:
            steps = result.work.get("contact_steps", 0)
        # A contact step has a relative error in the velocities, so twice this error in the energy.
        in_contact = 2.0 * contact_error(steps) * first_energy(result.scene)
        return largest_rise(energy, rounding + in_contact)
    rise = largest_rise(energy)
    if result.scene.physics.impacts == "compliant":
        return rise  # the cloth doesn't act during contacts, which last an unknown part of a step
    late = stated_error(resolution) / max(resolution_of_step(1.0, result.scene), TINY)
    return max(rise, float(np.max(_gains_at_impacts(result, frames, late), initial=0.0)))


def largest_rise(energy: FloatArray, rounding: FloatArray | float = 0.0) -> float:
    """Return the largest rise of energy above an earlier minimum [J]; 0 if there is none.

    `energy` (k,) float64 [J]: in order of time.
    `rounding` (k,) float64 [J]: the part of each rise that doesn't count.
    """
    return float(np.max(energy - np.minimum.accumulate(energy) - rounding, initial=0.0))


def _rounding(scene: Scene, times: FloatArray, energy: FloatArray) -> FloatArray:
    """Return the rounding error of the energy of an exact motion at each time, (k,) [J].

    A time is rounded to a double, which changes the energy by the loss on the cloth in the spacing
    of doubles; this is negligible unless a slow ball slides after days. For balls of masses m with
    the energy E, the sum of m (v + R w) is at most (1 + sqrt(5/2)) sqrt(2 E sum m). If balls may
    leave the cloth, heights are rounded, too: the initial heights, and the height to which all of
    the energy lifts balls.
    """
    frictions = np.maximum(scene.sliding_frictions, scene.rolling_frictions)
    strongest = scene.physics.gravity * float(np.max(frictions))
    taken = strongest * _SURFACE_SPEEDS * np.sqrt(2.0 * float(np.sum(scene.masses)) * energy)
    rounding: FloatArray = _ROUNDINGS_SEEN * np.spacing(times) * taken
    if scene.physics.airborne:
        at_first = scene.physics.gravity * float(scene.masses @ scene.positions[:, 2])
        rounding += _ROUNDINGS_SEEN * EPS * (at_first + float(energy[0]))
    return rounding


def _gains_at_impacts(result: Result, frames: SampledTrajectory, late: float) -> FloatArray:
    """Return the energy gain of each step with a collision, plus the loss on the cloth, (m,) [J].

    The loss during a time `late` [s] isn't added.
    """
    events = events_of(result)
    collisions = events["t"][np.isin(events["kind"], COLLISION_KINDS)]
    # A collision at the time of a frame may belong to the step before or after it. Two frames at
    # that time are the states before and after the collision.
    near = np.zeros(len(frames.times) + 1, dtype=np.int64)
    np.add.at(near, np.maximum(np.searchsorted(frames.times, collisions, side="left") - 1, 0), 1)
    np.add.at(near, np.searchsorted(frames.times, collisions, side="right"), -1)
    steps = np.flatnonzero(np.cumsum(near)[: len(frames.times) - 1] > 0)
    before, after = (_rows(frames, rows) for rows in (steps, steps + 1))
    durations = frames.times[steps + 1] - frames.times[steps]
    taken = least_cloth_loss(result.scene, before, after, durations)
    gained = energy_of(result.scene, after).total - energy_of(result.scene, before).total
    power = np.maximum(*(np.sum(_powers(result.scene, one), axis=1) for one in (before, after)))
    gains: FloatArray = gained + np.maximum(taken - late * power, 0.0)
    return gains


def _rows(frames: SampledTrajectory, rows: NDArray[np.intp]) -> Samples:
    return Samples(frames.positions[rows], frames.velocities[rows], frames.angular_velocities[rows])


def least_cloth_loss(
    scene: Scene, before: Samples, after: Samples, durations: FloatArray
) -> FloatArray:
    """Return a lower bound on the energy lost to the cloth in steps with a collision, (k,) [J].

    `before`, `after`: states at the start and end of each step, arrays (k, n, 3).
    `durations` (k,) float64 [s].

    The time of the collision within the step is unknown. Before it, friction acts as on undisturbed
    balls. After it, friction power is at least that at the end of the step, because it decreases
    with time. The bound is therefore the smaller of the loss of undisturbed balls and the final
    power times the duration.

    Friction power increases only when a slide with little slip becomes a roll. Hence, in scenes
    with sliding, a ball that was hit and rolls at the end contributes nothing. With several
    collisions in one step, the true loss may be below the bound.
    """
    undisturbed = _free_loss(scene, before, durations)
    power = _powers(scene, after)
    if scene.physics.motion == "sliding":
        change = np.linalg.norm((after.velocities - before.velocities)[..., :2], axis=2)
        slowed = scene.rolling_frictions * scene.physics.gravity * durations[:, np.newaxis]
        slips = _cloth(scene, after)[2] > _ROLLING_SLIP * np.linalg.norm(after.velocities, axis=2)
        power *= slips | (change <= 1.001 * slowed)
    least: FloatArray = np.minimum(undisturbed, durations * np.sum(power, axis=1))
    return least


def _free_loss(scene: Scene, states: Samples, durations: FloatArray) -> FloatArray:
    """Return the energy lost to the cloth by balls without collisions, (k,) [J].

    A sliding ball with slip u dissipates the power mu_s m g |u|; u decreases by 7/2 mu_s g per
    second, then the ball rolls. A rolling ball decelerates by mu_r g and has the energy 7/10 m v^2.
    """
    velocity, slip, speed, slides_by, rolls_by = _cloth(scene, states)
    time = durations[:, np.newaxis]
    with np.errstate(divide="ignore", invalid="ignore"):
        slide = np.where(slides_by > 0.0, np.minimum(time, speed / (3.5 * slides_by)), 0.0)
        unit = np.where(speed[..., np.newaxis] > 0.0, slip / speed[..., np.newaxis], 0.0)
    loss = scene.masses * slides_by * (speed * slide - 1.75 * slides_by * slide**2)
    rolling = np.linalg.norm(velocity - (slides_by * slide)[..., np.newaxis] * unit, axis=2)
    left = np.maximum(rolling - rolls_by * (time - slide), 0.0)
    # If slip is left at the end, there was no rolling.
    loss += np.where(slide < time, 0.7 * scene.masses * (rolling**2 - left**2), 0.0)
    total: FloatArray = np.sum(loss, axis=1)
    return total


def _powers(scene: Scene, states: Samples) -> FloatArray:
    """Return the power that the cloth dissipates for each ball, (k, n) [W]."""
    velocity, _, slip_speed, slides_by, rolls_by = _cloth(scene, states)
    rolls = 1.4 * rolls_by * np.linalg.norm(velocity, axis=2)
    slips = slip_speed > _ROLLING_SLIP * np.linalg.norm(velocity, axis=2)
    powers: FloatArray = scene.masses * np.where(slips, slides_by * slip_speed, rolls)
    return powers


def _cloth(
    scene: Scene, states: Samples
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return velocities and slips (k, n, 2), slip speeds (k, n), and both decelerations (n,).

    If balls always roll, slip and sliding deceleration are 0. For balls in the air, velocity and
    slip are set to 0, because the cloth doesn't act on them.
    """
    above = _above_cloth(scene, states)
    velocity = np.where(above[..., np.newaxis], 0.0, states.velocities[..., :2])
    slides = scene.physics.motion == "sliding"
    slip = np.zeros_like(velocity)
    if slides:
        spin = states.angular_velocities
        slip[..., 0] = velocity[..., 0] - scene.radii * spin[..., 1]
        slip[..., 1] = velocity[..., 1] + scene.radii * spin[..., 0]
        slip[above] = 0.0
    gravity = scene.physics.gravity
    return (
        velocity,
        slip,
        np.linalg.norm(slip, axis=2),
        scene.sliding_frictions * gravity * float(slides),
        scene.rolling_frictions * gravity,
    )


def _above_cloth(scene: Scene, states: Samples) -> NDArray[np.bool_]:
    """Return which balls are in the air, or leave or reach the cloth at that time, (k, n)."""
    if not scene.physics.airborne:
        return np.zeros(states.positions.shape[:2], dtype=np.bool_)
    high = states.positions[..., 2] > (1.0 + _ROUNDINGS_SEEN * EPS) * scene.radii
    vertical = np.abs(states.velocities[..., 2])
    speeds = np.linalg.norm(states.velocities, axis=2)
    above: NDArray[np.bool_] = high | (vertical > _VERTICAL_ROUNDING * speeds)
    return above
