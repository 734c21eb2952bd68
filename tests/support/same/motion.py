"""Checks that the events, the sampled motion and the end of a run agree and are possible."""

from __future__ import annotations

import numpy as np
from in_space import faults_in_space, gap_rounding
from right_shots import broken

from ghostball.engine.impacts.lasting_contacts import LYING
from ghostball.model import EventKind, ExactTrajectory, Phase, Result, Scene, Status
from ghostball.model.rounding import CONTACT_TOLERANCE, FLIGHT_CONTACT_TOLERANCE
from ghostball.validation.grading.tolerances import EPS
from ghostball.validation.stress import lasting
from ghostball.validation.stress.common_limits import POSSIBLE
from ghostball.validation.stress.shots import limit
from same.plays import played

MOST_PIECES = 4_000
"""Largest number of checked pieces of motion; if there are more, an even sample is checked."""


def ends(scene: Scene) -> str | None:
    """Return how a run stopped if not at rest or at `t_max`, or the error of its final state."""
    result = played(scene)
    if not result.status.complete:
        return f"it stops at {result.rest_time:.6g} s: {result.status.name}: {result.reason}"
    if result.status is Status.T_MAX:
        if result.rest_time != scene.t_max:
            return f"it stops at {result.rest_time!r} s instead of its `t_max`"
        return None
    here = result.phases(np.array([result.rest_time]))[0] != Phase.GONE
    if np.any(result.final_state.velocities[0, here]):
        return f"a ball moves at rest: {result.final_state.velocities[0].tolist()}"
    spins = np.abs(result.final_state.angular_velocities[0])
    # Spin without friction never ends, and a run doesn't wait for it. The cloth slows no ball that
    # lies on other balls.
    here &= result.rest_positions[:, 2] <= scene.radii * (1.0 + 4.0 * EPS)
    slides, turns = scene.sliding_frictions > 0.0, scene.spinning_friction_rates > 0.0
    if np.any(spins[here & slides, :2]) or np.any(spins[here & turns, 2]):
        return f"a ball turns at rest: {result.final_state.angular_velocities[0].tolist()}"
    return None


def sampled(scene: Scene) -> str | None:
    """Return how the sampled motion contradicts the events, the start or the end."""
    result = played(scene)
    assert result.events is not None
    times = result.events["t"]
    if np.any(np.diff(times) < 0.0) or np.any(times < 0.0) or np.any(times > result.rest_time):
        return "the events are not in order of time, from the start to the end"
    ends = np.array([0.0, result.rest_time])
    first, last = (np.array([part[k] for part in result.sample(ends)]) for k in (0, 1))
    if not np.all(np.isfinite((first, last))):
        return "the sampled motion isn't finite"
    given = np.array((scene.positions, scene.velocities, scene.angular_velocities))
    assert isinstance(result.trajectory, ExactTrajectory)
    kept = [
        np.sum(segments[:, 0] == 0.0) == 1 for segments in result.trajectory.segments
    ]  # for other balls, the pieces start again
    off = np.abs(first - given)[:, kept]
    if np.any(off > 8.0 * EPS * np.abs(given[:, kept])):
        return f"positions, velocities and spins at the start are off by {float(off.max()):.3g}"
    for name, one, wanted in zip(result.final_state._fields, last, result.final_state, strict=True):
        off = np.abs(one - wanted[0])
        if np.any(off > 16.0 * EPS * (1.0 + np.abs(wanted[0]))):
            return f"{name} sampled at the end are off by {float(off.max()):.3g}"
    return _gap_at_events(result) or _jump(result)


def invariants(scene: Scene) -> str | None:
    """Return an impossible property of a shot: overlap, rise of the energy, unsolved contacts."""
    result = played(scene)
    if scene.physics.airborne:
        return "; ".join(faults_in_space(result)) or None
    if not result.work.get("compliant_impacts"):
        return "; ".join(broken(result, *POSSIBLE)) or None
    most = lasting.INTEGRATION * result.collision_counts["ball-ball"]
    energy = (
        limit(metric, "Contacts that last are integrated.", at_most=most)
        for metric in ("energy_rise", "energy_drift")
    )
    return "; ".join(broken(result, *lasting.POSSIBLE, *energy)) or None


def _gap_at_events(result: Result) -> str | None:
    """Return a collision of two balls that don't touch at its time."""
    scene, events = result.scene, result.events
    assert events is not None
    met = events[events["kind"] == EventKind.BALL_BALL]
    states, rows = result.sample(met["t"]), np.arange(len(met))
    between = states.positions[rows, met["a"]] - states.positions[rows, met["b"]]
    between = between if scene.physics.airborne else between[:, :2]
    radii = scene.radii
    gaps = np.linalg.norm(between, axis=1) - radii[met["a"]] - radii[met["b"]]
    # Also the way of both balls during one rounding of the clock: the time of the collision is
    # rounded, and so is the time since the start of each motion.
    speeds = np.linalg.norm(states.velocities, axis=2)
    ways = 2.0 * (speeds[rows, met["a"]] + speeds[rows, met["b"]]) * np.spacing(met["t"])
    limits = _slack(result, states.positions) + ways
    # A contact that lasts begins at a small overlap.
    deepest = limits + (4.0 * LYING if scene.physics.impacts == "compliant" else 0.0)
    for a, b in {(int(one["a"]), int(one["b"])) for one in met[gaps < -limits]}:
        its = (met["a"] == a) & (met["b"] == b)
        deepest[its] += _left_by_impacts(result, a, b, met["t"][its], limits[its].max())
    if not np.all((-deepest <= gaps) & (gaps <= limits)):
        k = int(np.argmax(np.maximum(gaps - limits, -deepest - gaps)))
        return f"balls are {gaps[k]:.3g} m apart as they collide, {met[k].tolist()}"
    return None


def _left_by_impacts(result: Result, a: int, b: int, times: np.ndarray, apart: float) -> np.ndarray:
    """Return the largest overlap of two balls that rounding may have caused by each time [m].

    Each piece of a ball's motion starts at a rounded position, with an error of half an ulp of each
    coordinate. The resulting overlap counts as touching, and nothing removes it while inelastic
    impacts keep the balls together. So overlaps add up over all pieces of both balls since their
    gap was last larger than `apart` [m]. (A gap opened by rounding closes before the balls
    collide.)
    """
    assert isinstance(result.trajectory, ExactTrajectory)
    begins = np.concatenate([result.trajectory.segments[k][:, 0] for k in (a, b)])
    begins = np.sort(begins[begins <= times.max()])  # a start of both balls counts twice
    between = 0.5 * (begins + np.append(begins[1:], times.max()))
    dimensions = 3 if result.scene.physics.airborne else 2
    places = result.sample(between).positions[:, [a, b], :dimensions]
    gaps = np.linalg.norm(places[:, 0] - places[:, 1], axis=1) - result.scene.radii[[a, b]].sum()
    pieces = np.arange(len(begins))
    last = np.maximum.accumulate(np.where(gaps > apart, pieces, 0))
    before = np.maximum(np.searchsorted(begins, times) - 1, 0)
    each = 0.5 * float(np.spacing(np.abs(places).max(axis=0)).sum())
    return np.asarray(each * (before - last[before]))


def _jump(result: Result) -> str | None:
    """Return the jump of a ball between two pieces of its motion, if there is one."""
    assert isinstance(result.trajectory, ExactTrajectory)
    instants = np.unique(
        np.concatenate([segments[:, 0] for segments in result.trajectory.segments])
    )
    instants = instants[(instants > 0.0) & (instants <= result.rest_time)]
    some = np.linspace(0, len(instants) - 1, min(len(instants), MOST_PIECES)).astype(np.int64)
    instants = instants[some]
    before, after = result.sample(np.nextafter(instants, 0.0)), result.sample(instants)
    size = np.maximum(np.abs(before.velocities), np.abs(after.velocities))
    way = size * np.spacing(instants)[:, np.newaxis, np.newaxis]
    off = np.abs(after.positions - before.positions) - way
    # The way of a stopping ball is the difference of two terms, one of them twice as long.
    limit = _slack(result, after.positions)
    limit += gap_rounding(result.scene, after.positions) if len(instants) else 0.0
    if len(off) and not off.max() <= limit:
        k, i, _ = np.unravel_index(int(np.argmax(off)), off.shape)
        return f"ball {i} jumps by {off.max():.3g} m at {instants[k]!r} s"
    return None


def _slack(result: Result, places: np.ndarray) -> float:
    """Return the tolerance for contacts and for joints of pieces [m]."""
    diameter = 2.0 * float(result.scene.radii.max())
    slack = gap_rounding(result.scene, places) if len(places) else 0.0
    if result.work["contact_steps"]:
        slack += CONTACT_TOLERANCE * diameter
    return slack + (FLIGHT_CONTACT_TOLERANCE * diameter if result.scene.physics.airborne else 0.0)
