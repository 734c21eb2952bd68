"""How much energy a run makes that nothing in its scene can give.

Cloth, cushions and impacts only take energy. What an impact makes is small beside what the cloth
takes between two looks at the motion, so the looks have to be close to the impact. An exact motion
is looked at the last instant before each event and at the event. A stepping engine is known at its
frames alone: where balls collide between two of them, what the cloth takes meanwhile is added to
the difference, for else a gain would hide behind it.
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
from ghostball.validation.grading.tolerances import CONTACT_STEP, EPS
from ghostball.validation.runs.sampling import energy_series, energy_times, events_of

_ROLLS = 1e-12
"""Slip, in units of a ball's speed, that is but the rounding of a frame of a ball that rolls."""

_VERTICAL_ROUNDING = 1e-12
"""Vertical speed, in units of a ball's speed, that is but rounding for a ball on the cloth."""

_ROUNDINGS_SEEN = 4.0
"""Roundings of an instant, or of a height, that are no gain."""

_MOST_CONTACT_STEPS = 64
"""Steps of a contact that may err the same way: more than one takes from its start to its end."""

_SURFACE_SPEEDS = 1.0 + math.sqrt(2.5)
"""Largest sum of m (v + R w) over all balls, in units of sqrt(2 E sum m); see `_rounding`."""

TINY = float(np.finfo(np.float64).tiny)
"""The fastest speed of a scene at rest [m/s]: a quotient by it is finite, or infinite for good."""


def largest_gain(result: Result, resolution: Resolution = 0.0, *, pressed: bool = False) -> float:
    """Return the most energy that a run makes [J]; 0 if none, NaN where its energy isn't finite.

    The largest of the rises above the least energy before, and, of an engine that steps, of the
    gains in those of its steps in which balls collide.

    `resolution` [m]: how far off a ball may be when it collides, as the engine states it:
    `resolution_of`.

    An engine that sees contacts late resolves them from speeds that are as old: Chipmunk bounces
    balls with those that they had before its step, and so gives back what the cloth took in it.
    What the cloth takes while the fastest ball goes `resolution` is therefore no gain. Nor is what
    rounding makes of an exact motion: of its heights, and of the instants at which it is looked at;
    and what steps of sustained contact may err by.

    `pressed`: whether the shot has sustained contacts; used for engines that don't count their
    contact steps.
    """
    energy = energy_series(result)
    frames = result.trajectory
    if not isinstance(frames, SampledTrajectory):
        rounding = _rounding(result.scene, energy_times(result), energy)
        steps = _MOST_CONTACT_STEPS if pressed else 0
        if result.engine == OURS:
            steps = min(result.work.get("contact_steps", 0), _MOST_CONTACT_STEPS)
        # A step errs by a part of the velocities, and so by twice that of the energy.
        in_contact = 2.0 * CONTACT_STEP * first_energy(result.scene) * (1 + steps) if steps else 0.0
        return largest_rise(energy, rounding + in_contact)
    rise = largest_rise(energy)
    late = stated_error(resolution) / max(resolution_of_step(1.0, result.scene), TINY)
    return max(rise, float(np.max(_gains_at_impacts(result, frames, late), initial=0.0)))


def largest_rise(energy: FloatArray, rounding: FloatArray | float = 0.0) -> float:
    """Return by how much energy ever exceeds the least before it [J]; 0 if never.

    `energy` (k,) float64 [J]: in order of time.
    `rounding` (k,) float64 [J]: what of each is no rise.
    """
    return float(np.max(energy - np.minimum.accumulate(energy) - rounding, initial=0.0))


def _rounding(scene: Scene, times: FloatArray, energy: FloatArray) -> FloatArray:
    """Return how much of the energy of an exact motion is rounding at each instant, (k,) [J].

    The clock rounds an instant, to what the cloth takes in its spacing: next to nothing, unless a
    slow ball slides after days. Balls of masses m with the energy E move and turn such that the sum
    of m (v + R w) is at most (1 + sqrt(5/2)) sqrt(2 E sum m). Where balls may leave the cloth, a
    height is rounded, too: as those at first, and as what all of the energy lifts balls by.
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
    """Return what each step with a collision leaves beyond what the cloth takes in it, (m,) [J].

    Less what the cloth takes in a time `late` [s].
    """
    events = events_of(result)
    collisions = events["t"][np.isin(events["kind"], COLLISION_KINDS)]
    # A collision at the instant of a frame may belong to the step before or to the one after; two
    # frames of that instant are the states on both sides of it.
    near = np.zeros(len(frames.times) + 1, dtype=np.int64)
    np.add.at(near, np.maximum(np.searchsorted(frames.times, collisions, side="left") - 1, 0), 1)
    np.add.at(near, np.searchsorted(frames.times, collisions, side="right"), -1)
    steps = np.flatnonzero(np.cumsum(near)[: len(frames.times) - 1] > 0)
    before, after = (_rows(frames, rows) for rows in (steps, steps + 1))
    durations = frames.times[steps + 1] - frames.times[steps]
    taken = cloth_takes(result.scene, before, after, durations)
    gained = energy_of(result.scene, after).total - energy_of(result.scene, before).total
    power = np.maximum(*(np.sum(_powers(result.scene, one), axis=1) for one in (before, after)))
    gains: FloatArray = gained + np.maximum(taken - late * power, 0.0)
    return gains


def _rows(frames: SampledTrajectory, rows: NDArray[np.intp]) -> Samples:
    return Samples(frames.positions[rows], frames.velocities[rows], frames.angular_velocities[rows])


def cloth_takes(scene: Scene, before: Samples, after: Samples, durations: FloatArray) -> FloatArray:
    """Return the least energy that the cloth takes in steps in which balls collide, (k,) [J].

    `before`, `after`: states at both ends of each step, arrays (k, n, 3).
    `durations` (k,) float64 [s].

    The collision comes at an unknown instant of the step. Before it the balls are slowed as if
    there were none; after it they are slowed as at the step's end, or more, since the power of
    friction falls on the way. So the cloth takes at least the smaller of what it takes from
    undisturbed balls and of the power at the end times the duration.

    Power rises where a slide of little slip turns into rolling: of a ball that was hit and rolls at
    the end, where balls may slide, nothing is counted. What balls lose between several collisions
    in one step may be less still.
    """
    undisturbed = _free_loss(scene, before, durations)
    power = _powers(scene, after)
    if scene.physics.motion == "sliding":
        change = np.linalg.norm((after.velocities - before.velocities)[..., :2], axis=2)
        slowed = scene.rolling_frictions * scene.physics.gravity * durations[:, np.newaxis]
        slips = _cloth(scene, after)[2] > _ROLLS * np.linalg.norm(after.velocities, axis=2)
        power *= slips | (change <= 1.001 * slowed)
    least: FloatArray = np.minimum(undisturbed, durations * np.sum(power, axis=1))
    return least


def _free_loss(scene: Scene, states: Samples, durations: FloatArray) -> FloatArray:
    """Return what the cloth takes from balls that meet nothing for a while, (k,) [J].

    A sliding ball loses mu_s m g |u| of power while its slip u falls by 7/2 mu_s g a second, and
    then rolls; a rolling one loses speed at mu_r g, and has 7/10 m v^2.
    """
    velocity, slip, speed, slides_by, rolls_by = _cloth(scene, states)
    time = durations[:, np.newaxis]
    with np.errstate(divide="ignore", invalid="ignore"):
        slide = np.where(slides_by > 0.0, np.minimum(time, speed / (3.5 * slides_by)), 0.0)
        unit = np.where(speed[..., np.newaxis] > 0.0, slip / speed[..., np.newaxis], 0.0)
    loss = scene.masses * slides_by * (speed * slide - 1.75 * slides_by * slide**2)
    rolling = np.linalg.norm(velocity - (slides_by * slide)[..., np.newaxis] * unit, axis=2)
    left = np.maximum(rolling - rolls_by * (time - slide), 0.0)
    # With slip left at the end, nothing has rolled.
    loss += np.where(slide < time, 0.7 * scene.masses * (rolling**2 - left**2), 0.0)
    total: FloatArray = np.sum(loss, axis=1)
    return total


def _powers(scene: Scene, states: Samples) -> FloatArray:
    """Return the power that the cloth takes from each ball at an instant, (k, n) [W]."""
    velocity, _, slip_speed, slides_by, rolls_by = _cloth(scene, states)
    rolls = 1.4 * rolls_by * np.linalg.norm(velocity, axis=2)
    slips = slip_speed > _ROLLS * np.linalg.norm(velocity, axis=2)
    powers: FloatArray = scene.masses * np.where(slips, slides_by * slip_speed, rolls)
    return powers


def _cloth(
    scene: Scene, states: Samples
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return velocities and slips (k, n, 2), the slips' sizes (k, n), and both decelerations (n,).

    Where balls always roll, slip is 0 and nothing slides. The cloth takes nothing from balls in the
    air, as if they rested.
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
    """Return which balls are in the air, or leave or reach the cloth at that instant, (k, n)."""
    if not scene.physics.airborne:
        return np.zeros(states.positions.shape[:2], dtype=np.bool_)
    high = states.positions[..., 2] > (1.0 + _ROUNDINGS_SEEN * EPS) * scene.radii
    vertical = np.abs(states.velocities[..., 2])
    speeds = np.linalg.norm(states.velocities, axis=2)
    above: NDArray[np.bool_] = high | (vertical > _VERTICAL_ROUNDING * speeds)
    return above
