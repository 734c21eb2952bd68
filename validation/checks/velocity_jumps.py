"""Energy in changes of velocity that neither a contact, the cloth nor air explains.

The cloth changes the velocity of a ball by mu_s g per second while it slides, and by mu_r g while
it rolls; air changes it by k v^2. Only a contact changes it faster. So a run in which a ball
suddenly stops or turns without a contact is unphysical, whatever its reference.
"""

from __future__ import annotations

import numpy as np

from ghostball.model import (
    COLLISION_KINDS,
    EventKind,
    Events,
    Result,
    SampledTrajectory,
    Scene,
    Status,
)
from ghostball.model.arrays import BoolArray, FloatArray, IntArray
from ghostball.model.events import LEAVING_KINDS
from ghostball.reference_adapters.base import Resolution, resolution_of_step, stated_error
from ghostball.validation.grading.near_misses import gaps_of, things_of
from ghostball.validation.runs.sampling import energy_times, events_of, times_gone

_CONTACTS = (*COLLISION_KINDS, *LEAVING_KINDS)
"""Kinds of events that may change a velocity at once if no ball flies."""

_TOUCHING_GAP = 1e-3
"""Gap at which a ball counts as touching a body, in units of the smallest radius."""

_LARGEST_PART = 200_000
"""Number of samples times balls in a part; at most four times as many positions are compared."""


def largest_jump(result: Result, resolution: Resolution = 0.0, *, share: float = 0.0) -> float:
    """Return the largest energy of unexplained changes of velocity between two instants [J].

    It is the sum of m dv^2 / 2 over the balls; dv is the part of a change of velocity that exceeds
    the effect of the cloth and the air. The result is 0 if balls may fly, because a landing is a
    contact with the cloth.

    `resolution` [m]: of the engine, see `reference_adapters.base.resolution_of`. A time-stepping
    engine may report a contact one step earlier or later than its motion shows the contact. A
    report explains a change only if the ball could have touched something at that time.
    `share` [J]: an energy that doesn't exceed this value is returned as 0.

    At the end of a run with the status "rest", all velocities are 0.
    """
    scene = result.scene
    if scene.physics.airborne:
        return 0.0
    times, positions, velocities = _states(result)
    late = stated_error(resolution)
    fastest = resolution_of_step(1.0, scene)
    step = 2.0 * late / fastest if fastest > 0.0 else 0.0
    speeds = np.linalg.norm(velocities[..., :2], axis=2)
    changes = np.linalg.norm(np.diff(velocities[..., :2], axis=0), axis=2)
    lasts = (np.diff(times) + step)[:, np.newaxis]
    beyond = changes - lasts * _slowed(scene, np.maximum(speeds[:-1], speeds[1:]))
    beyond[times[:-1, np.newaxis] >= times_gone(result)] = 0.0
    energies = 0.5 * scene.masses * np.maximum(beyond, 0.0) ** 2
    # An engine without a stated resolution may use each interval of samples as a time step.
    ends = np.concatenate([times[:1], times, times[-1:]])
    since, until = ends[:-3] - step, ends[3:] + step
    suspect, top = np.sum(energies, axis=1) > share, np.max(speeds, axis=1)
    for ball in range(len(scene.balls)):
        contacts = _contacts_of(ball, events_of(result))
        before, after = np.searchsorted(contacts, since), np.searchsorted(contacts, until, "right")
        changed = suspect & (energies[:, ball] != 0.0)
        for more, reported in enumerate((after <= before, after > before)):
            for k in _parts(np.flatnonzero(changed & reported), len(scene.balls)):
                # A report counts from the sample before to the sample after it, and one more step
                # on each side.
                window = np.arange(-more, 2 + more)
                rows = np.clip(k[:, np.newaxis] + window, 0, len(times) - 1)
                # Two balls may close their gap by this length [m] from one sample to the next.
                longest = np.max(np.diff(times[rows], axis=1), axis=1)
                near = 2.0 * ((1 + more) * late + np.max(top[rows], axis=1) * longest)
                energies[k[_touches(scene, ball, positions, rows, near)], ball] = 0.0
    largest = float(np.max(np.sum(energies, axis=1), initial=0.0))
    return largest if largest > share else 0.0


def _states(result: Result) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return times (k,) [s], and the positions and velocities at these times, (k, n, 3) each."""
    frames = result.trajectory
    if isinstance(frames, SampledTrajectory):
        times, positions, velocities = frames.times, frames.positions, frames.velocities
    else:
        times = energy_times(result)
        positions, velocities, _ = result.sample(times)
    if result.status is Status.REST:
        times = np.append(times, max(float(result.rest_time), float(times[-1])))
        positions = np.concatenate([positions, positions[-1:]])
        velocities = np.concatenate([velocities, np.zeros_like(velocities[-1:])])
    return times, positions, velocities


def _slowed(scene: Scene, speeds: FloatArray) -> FloatArray:
    """Return the largest deceleration on the cloth at speeds (k, n) [m/s], (k, n) [m/s^2]."""
    physics = scene.physics
    friction = scene.rolling_frictions
    if physics.motion == "sliding":
        friction = np.maximum(friction, scene.sliding_frictions)
    drag = physics.air_drag + physics.rolling_friction_quadratic
    slowed: FloatArray = physics.gravity * friction + drag * speeds**2
    return slowed


def _contacts_of(ball: int, events: Events) -> FloatArray:
    """Return the times at which a ball has a contact or leaves the table, (m,) [s], increasing."""
    mine = (events["a"] == ball) | ((events["kind"] == EventKind.BALL_BALL) & (events["b"] == ball))
    contacts: FloatArray = np.sort(events["t"][mine & np.isin(events["kind"], _CONTACTS)])
    return contacts


def _parts(numbers: IntArray, balls: int) -> list[IntArray]:
    """Split the numbers of samples, so that each part needs little memory."""
    size = max(_LARGEST_PART // balls, 1)
    return [numbers[start : start + size] for start in range(0, len(numbers), size)]


def _touches(
    scene: Scene, ball: int, positions: FloatArray, rows: IntArray, near: FloatArray
) -> BoolArray:
    """Return for each of k intervals whether a ball may nearly touch a body, (k,) bool.

    `near` (k,) [m]: how far the ball may be away from touching.
    `rows` (k, m): the samples of `positions` (samples, n, 3) [m] that belong to each interval.
    """
    used, places = np.unique(rows, return_inverse=True)
    at, radii = positions[used], scene.radii
    others = [other for other in range(len(scene.balls)) if other != ball]
    away = np.linalg.norm((at - at[:, ball : ball + 1])[:, others, :2], axis=2)
    gaps = np.min(away - radii[others] - radii[ball], axis=1, initial=np.inf)
    for one in things_of(scene):
        gaps = np.minimum(gaps, gaps_of(scene, ball, one, at))
    nearest = np.min(gaps[places.reshape(rows.shape)], axis=1)
    touches: BoolArray = nearest <= _TOUCHING_GAP * float(np.min(radii)) + near
    return touches
