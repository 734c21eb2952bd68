"""Compare a run with the run of a related shot, within the error that the engine itself states.

Two runs of one engine may differ by twice the error that it makes in one run: at each event, its
`resolution`, or some roundings. The growth of errors along the shot turns this error into an
allowed distance at each time. It is the growth along the certified motion or, without one, along
the motion of Ghostball's own engine, so the engine that is judged doesn't decide it. Between two
recorded frames, the error of the interpolation is added.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ghostball.model import EventKind, Result, Scene, first_energy
from ghostball.model.arrays import FloatArray
from ghostball.model.features import scene_features
from ghostball.reference_adapters.base import ReferenceEngine, resolution_of, stated_error
from ghostball.validation.checks.related_shots import RelatedShot
from ghostball.validation.grading.event_logs import Event, compare_logs, events_in
from ghostball.validation.grading.horizon import SampledGrowth
from ghostball.validation.grading.near_misses import gaps_of, things_of
from ghostball.validation.grading.tolerances import ROUNDINGS, TIE, UNIT_ROUNDOFF
from ghostball.validation.results.quantities import scaled
from ghostball.validation.results.records import RelatedRun
from ghostball.validation.runs.sampling import events_of, frames_of

UNSTATED_ERROR = 1e-6
"""Error of an engine that states no `resolution` and supports every feature exactly [m].

It is the limit of the accuracy class "nanometres", which the law asks of such an engine.
"""

_RUNS = 2.0
"""Number of runs with errors: both."""

_NEAR = 257
"""Number of times at which the gap of a possible near miss is sampled."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """A run and the run of a related shot.

    `factor`: largest distance of a ball between the runs, in units of the allowed distance; None if
        nothing could be compared.
    `words`: the largest difference and the compared time, or why nothing could be compared.
    `differing`: numbers that differ in any bit: positions at the compared times, and the end.
    `ends`: both runs at the time of `factor`.
    """

    factor: float | None
    words: str
    differing: int
    ends: RelatedRun


def compare_runs(
    result: Result, related: RelatedShot, second: Result, growth: SampledGrowth, error: float | None
) -> Comparison:
    """Compare a run with the run of a related shot by the same engine.

    `growth`: growth of errors along the shot.
    `error`: error of the engine at each event of one run, relative to the extent of the scene
        (`relative_error`); None if it is unknown.
    """
    ends = (result.rest_time, second.rest_time / related.clock + related.start)
    until = growth.horizon(error or 0.0)
    last = max(math.nextafter(min(until, *ends), 0.0), 0.0)  # few times may come before
    looks = np.union1d(growth.times, [*ends, last])
    looks = looks[looks >= related.start]
    positions, expected = _both(result, related, second, looks)
    distances = np.linalg.norm(expected - positions, axis=2)
    if related.added:
        # nothing reaches the added balls, so they stay where they are
        left = second.sample(related.times(looks)).positions[:, list(related.added)]
        moved = np.linalg.norm(left - related.scene.positions[list(related.added)], axis=2)
        distances = np.hstack([distances, moved])
    off: FloatArray = np.max(distances, axis=1, initial=0.0)
    differing = int(np.count_nonzero(expected != positions)) + int(ends[0] != ends[1])

    def compared(factor: float | None, words: str, t: float) -> Comparison:
        return Comparison(factor, words, differing, _ends_at(result, related, second, t))

    if error is None:
        why = "the engine states no `resolution`, and supports the scene only approximately"
        return compared(None, why, ends[0])
    error = max(error, growth.least_error)
    allowed = _RUNS * error * _sizes(growth, looks)
    allowed += _between_frames(result, looks)
    allowed += _between_frames(second, related.times(looks)) / related.unit
    radius = float(np.min(result.scene.radii))
    counts = (looks < until) & (allowed < radius) & (looks > related.start)
    shares = np.where(counts, off / allowed, 0.0)
    beyond = np.flatnonzero(~(shares <= 1.0))
    if len(beyond):
        k = int(beyond[0])
        missed_at = _near_miss(result, related, second, looks[k], allowed[k])
        if missed_at is not None:
            counts &= looks < missed_at
            shares = np.where(counts, shares, 0.0)
    if not np.any(counts):
        why = "the engine's own error may change the shot from the start, so nothing is compared"
        return compared(None, why, ends[0])
    worst = int(np.argmax(np.where(np.isnan(shares), math.inf, shares)))
    last, end = float(looks[counts][-1]), max(ends)
    said = (
        f"{scaled(float(off[worst]), 'm')} apart at t = {looks[worst]:.4g} s, where the engine's "
        f"own error explains {scaled(float(allowed[worst]), 'm')}; compared up to t = {last:.4g} s"
    )
    said += "" if last >= end else f" of {end:.4g} s"
    return compared(float(shares[worst]), said, float(looks[worst]))


def _both(
    result: Result, related: RelatedShot, second: Result, times: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the positions of a run, and those expected from the second, (m, k, 3) [m]."""
    theirs = second.sample(np.maximum(related.times(times), 0.0)).positions
    return result.sample(times).positions[:, related.kept], related.expected(times, theirs)


def own_error(engine: ReferenceEngine, scene: Scene, growth: SampledGrowth) -> float | None:
    """Return the relative error of an engine at each event; None if it states nothing about it."""
    stated = _stated(engine, scene)
    if stated is None:
        return None
    return max(ROUNDINGS * UNIT_ROUNDOFF, stated / growth.coordinate)


def relative_error(
    engine: ReferenceEngine,
    result: Result,
    related: RelatedShot,
    second: Result,
    growth: SampledGrowth,
) -> float | None:
    """Return the larger relative error of an engine in two related runs; see `own_error`.

    Rounding is larger if the second shot has larger coordinates.
    """
    error = own_error(engine, result.scene, growth)
    other = _stated(engine, related.scene)
    if error is None or other is None:
        return None
    kept = [index for index in related.order if index >= 0]
    places = second.sample(np.linspace(0.0, second.rest_time, 65)).positions[:, kept]
    reach = float(np.max(np.abs(places))) / related.unit
    rounding = ROUNDINGS * UNIT_ROUNDOFF * max(1.0, reach / growth.extent)
    return max(error, rounding, other / (related.unit * growth.coordinate))


def _stated(engine: ReferenceEngine, scene: Scene) -> float | None:
    """Return the position error that an engine states for an event [m]; None if it states none."""
    stated = resolution_of(engine, scene)
    if stated is not None:
        return stated_error(stated)
    known = engine.capabilities
    features = [known[one] for one in scene_features(scene) if one in known]
    if any(one.support == "approximate" for one in features):
        return None
    return UNSTATED_ERROR


def _sizes(growth: SampledGrowth, looks: FloatArray) -> FloatArray:
    """Return the displacement by relative errors of 1 up to the next time of the growth, (m,) [m].

    The next time counts, because errors may delay an event past a time of comparison.
    The growth is the rms over errors of random signs. Errors of one sign, such as those of late
    contacts, add up to at most the root of their number times the rms (Cauchy and Schwarz).
    """
    later = np.searchsorted(growth.times, looks, side="right")
    worst = growth.largest * np.sqrt(growth.events)
    following = worst[np.minimum(later, len(growth.times) - 1)]
    here = worst[np.maximum(later - 1, 0)]
    sizes: FloatArray = np.where(np.isfinite(following), following, here)
    return sizes


def _between_frames(result: Result, times: FloatArray) -> FloatArray:
    """Return the largest error of positions between two recorded frames, (m,) [m]; 0 at a frame.

    They are interpolated linearly. A ball with the acceleration a leaves the chord of its path by
    at most a (time between the frames)^2 / 8; friction, gravity and drag bound a.
    """
    frames, scene = frames_of(result), result.scene
    if frames is None:
        return np.zeros(len(times))
    physics = scene.physics
    drag = physics.air_drag + physics.rolling_friction_quadratic
    fastest = 2.0 * first_energy(scene) / float(np.min(scene.masses))
    grip = np.max(scene.rolling_frictions) + np.max(scene.sliding_frictions)
    largest = physics.gravity * (float(grip) + physics.airborne) + drag * fastest
    after = np.searchsorted(frames.times, times)
    after = np.clip(after, 1, len(frames.times) - 1)
    ends, starts = frames.times[after], frames.times[after - 1]
    between = (times > starts) & (times < ends)
    error: FloatArray = np.where(between, 0.125 * largest * (ends - starts) ** 2, 0.0)
    return error


def _near_miss(
    result: Result, related: RelatedShot, second: Result, t: float, allowed: float
) -> float | None:
    """Return the time of a near miss that explains why the runs differ at `t` [s], or None.

    One run has a collision that the other misses by less than `allowed` [m], as when a ball meets
    two bodies at almost the same instant.
    """
    first, other = _log(events_of(result)), _log_of_second(related, second)
    parting = compare_logs(first, other).parting
    if parting is None:
        return None
    event, scene = parting.first, result.scene
    mine = event is parting.other  # the collision is missing from the first run
    kept = related.kept.tolist()
    if not all(ball in kept for ball in event.balls):
        return None
    state = result.sample([event.t]).velocities[0, list(event.balls)]
    fastest = max(float(np.max(np.abs(state))), math.ulp(0.0))
    if event.t > t * (1.0 + TIE) + allowed / fastest:
        return None
    window = float(np.min(scene.radii)) / fastest
    low = max(event.t - window, related.start)
    times = np.linspace(low, event.t + window, _NEAR)
    centres = np.full((_NEAR, len(scene.balls), 3), np.nan)
    centres[:, kept] = _both(result, related, second, times)[0 if mine else 1]
    things = [event.b] if event.kind is EventKind.BALL_BALL else things_of(scene)
    gaps = [float(np.min(gaps_of(scene, event.a, one, centres))) for one in things]
    return event.t if any(abs(gap) <= allowed for gap in gaps) else None


def _log(events: np.ndarray) -> list[Event]:
    """Return the collisions of a run; cushions aren't told apart, as relations exchange them."""
    return [
        one if one.kind is EventKind.BALL_BALL else Event(one.kind, one.a, -1, one.t, one.index)
        for one in events_in(events)
    ]


def _log_of_second(related: RelatedShot, second: Result) -> list[Event]:
    """Return the collisions of the second run, with the balls and times of the first."""
    events = events_of(second).copy()
    back = np.full(len(related.scene.balls), -1)
    for index, there in enumerate(related.order):
        if there >= 0:
            back[there] = index
    of_balls = events["kind"] == EventKind.BALL_BALL
    events["b"][of_balls] = back[events["b"][of_balls]]
    events["a"] = back[events["a"]]
    events["t"] = events["t"] / related.clock + related.start
    return _log(events[(events["a"] >= 0) & (~of_balls | (events["b"] >= 0))])


def _ends_at(result: Result, related: RelatedShot, second: Result, t: float) -> RelatedRun:
    """Return the positions of all balls in both runs at a time [s]; nan if a ball isn't there."""
    places = np.full((2, len(result.scene.balls), 3), np.nan)
    places[:, related.kept] = np.array(_both(result, related, second, np.array([t])))[:, 0]
    return RelatedRun(t, places[0], places[1])
