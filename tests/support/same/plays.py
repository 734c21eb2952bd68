"""Checks that one shot, simulated in several ways, gives bit-identical results."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from typing import Any, Final

import numpy as np

from ghostball.engine import (
    STATUSES,
    Batch,
    simulate,
    simulate_many,
    simulate_starts,
    simulate_sweep,
)
from ghostball.engine.running import skips
from ghostball.engine.running.skips import BUILT_IN, Skip, explain_skips
from ghostball.model import Ball, Record, Result, Scene
from ghostball.model.hashes import log_bits
from ghostball.model.sines import cosines_and_sines

MOST_EVENTS = 1_000_000
MOST_WORK = 4_000_000_000
"""Limits of a random scene on events and contact steps, and on work, below a run's defaults.

Nearly all scenes need a ten-thousandth of the limits. Balls that rest on each other in the air, and
balls that move very slowly in contact without cloth friction, need the most.
"""

THREADS: Final = (1, 2, 5)

PARTS: Final = (Skip.AIR_AND_FLIGHT,)
"""Skips of parts of the kernels; disabled together, so that only one more kernel is compiled."""

ALONE: Final = tuple(
    skip for skip in Skip if skip not in {*PARTS, *BUILT_IN, Skip.ADVANCEMENT, Skip.FAR_CELLS}
)
"""Skips that are disabled one by one, without `ADVANCEMENT`, which may change rounding, and
`FAR_CELLS`, which the check `cells` tests in the opposite direction."""

_LAST: list[Result] = []


def play(scene: Scene, record: Record = "trajectory", no_skip: Collection[str] = ()) -> Result:
    """Simulate a random scene within the limits of this module."""
    return simulate(
        scene, record=record, no_skip=no_skip, max_events=MOST_EVENTS, max_work=MOST_WORK
    )


def played(scene: Scene) -> Result:
    """Return the run for all comparisons; the run of the last scene is cached."""
    if not (_LAST and _LAST[0].scene is scene):
        _LAST[:] = [play(scene)]
    return _LAST[0]


def records(scene: Scene) -> str | None:
    """Return the difference if less is recorded."""
    base = played(scene)
    others: tuple[Record, ...] = ("rest", "events")
    return _first(
        difference(base, play(scene, record), f'`record="{record}"`') for record in others
    )


def many(scene: Scene) -> str | None:
    """Return the difference if the shot is one of a batch, on several numbers of threads."""
    base = played(scene)
    return _first(
        _of_batch(
            [base] * 2,
            simulate_many([scene] * 2, threads=threads, max_events=MOST_EVENTS, max_work=MOST_WORK),
            threads,
        )
        for threads in THREADS
    )


def sweep(scene: Scene, shots: int = 3) -> str | None:
    """Return the difference if the shot is one of a sweep, on several numbers of threads.

    The first and the last shot of the sweep are equal.
    """
    cue = next((k for k, ball in enumerate(scene.balls) if any(ball.velocity[:2])), None)
    if cue is None:
        return None
    ball = scene.balls[cue]
    speed = math.hypot(*ball.velocity[:2])
    speeds = speed * (1.0 - 0.5 * np.arange(shots) / shots)
    angles = math.atan2(ball.velocity[1], ball.velocity[0]) + np.arange(shots) / shots
    speeds[-1], angles[-1] = speeds[0], angles[0]
    singles = [play(one, "rest") for one in _single_shots(scene, cue, speeds[:-1], angles[:-1])]
    singles.append(singles[0])
    return _first(
        _of_batch(
            singles,
            simulate_sweep(
                scene,
                speeds,
                angles,
                ball=cue,
                threads=threads,
                max_events=MOST_EVENTS,
                max_work=MOST_WORK,
            ),
            threads,
        )
        for threads in THREADS
    )


def starts(scene: Scene) -> str | None:
    """Return the difference if the shot is given by arrays of initial states of resting balls.

    The first and the last state are equal; in the states between, all balls move half as fast.
    """
    still = {"velocity": (0.0, 0.0, 0.0), "angular_velocity": None}
    slow = [
        Ball(
            **{
                **dict(ball.without_strike()),
                "velocity": tuple(0.5 * v for v in ball.velocity),
                "angular_velocity": ball.angular_velocity
                and tuple(0.5 * w for w in ball.angular_velocity),
            }
        )
        for ball in scene.balls
    ]
    rest = with_balls(
        scene, [Ball(**{**dict(ball.without_strike()), **still}) for ball in scene.balls]
    )
    slower = play(with_balls(scene, slow), "rest")
    turned = any(ball.angular_velocity is not None for ball in scene.balls)
    each = np.array([1.0, 0.5, 1.0])[:, None, None]
    batch = simulate_starts(
        rest,
        scene.positions,
        each * scene.velocities,
        each * scene.angular_velocities if turned else None,
        threads=2,
        max_events=MOST_EVENTS,
        max_work=MOST_WORK,
    )
    return _of_batch([played(scene), slower, played(scene)], batch, 2)


def cells(scene: Scene) -> str | None:
    """Return the difference if the grid schedules the impacts, for any number of balls.

    The run also uses all parts of the kernels.
    """
    with cells_for_all():
        other = play(_anew(scene), no_skip=PARTS)
    return difference(played(scene), other, f"with cells, without the skips {', '.join(PARTS)}")


def skipped(scene: Scene) -> str | None:
    """Return the difference if skips that the scene uses are disabled."""
    base = played(scene)
    used = {use.skip for use in explain_skips(scene, record="events") if use.used}
    offs: list[tuple[Skip, ...]] = [(skip,) for skip in ALONE if skip in used]
    offs.append(tuple(skip for skip in PARTS if skip in used))
    return _first(
        difference(
            base,
            play(scene, no_skip=off),
            f"without the skips {', '.join(off)}",
        )
        for off in offs
    )


@contextmanager
def cells_for_all() -> Iterator[None]:
    """Let the grid schedule the impacts of any number of balls within the block."""
    most, skips.MOST_PAIRED = skips.MOST_PAIRED, 0
    try:
        yield
    finally:
        skips.MOST_PAIRED = most


def difference(base: Result, other: Result, how: str) -> str | None:
    """Return the first difference of two runs, bit by bit; 0.0 and -0.0 are equal."""
    if base.status is not other.status:
        return f"{how}: {other.status.name} ({other.reason}) instead of {base.status.name}"
    if base.events is not None and other.events is not None:
        ours, theirs = base.events, other.events
        same = min(len(ours), len(theirs))
        differ = ours[:same] != theirs[:same]
        if np.any(differ):
            k = int(np.argmax(differ))
            return f"{how}: event {k} is {theirs[k].tolist()} instead of {ours[k].tolist()}"
        if len(ours) != len(theirs):
            return f"{how}: {len(theirs)} events instead of {len(ours)}"
        assert log_bits(ours) == log_bits(theirs)
    if base.rest_time != other.rest_time:
        return f"{how}: ends at {other.rest_time!r} s instead of {base.rest_time!r} s"
    if base.collision_counts != other.collision_counts:
        return f"{how}: {other.collision_counts} instead of {base.collision_counts}"
    for name, one, two in zip(
        base.final_state._fields, base.final_state, other.final_state, strict=True
    ):
        if not np.array_equal(one, two):
            off = float(np.max(np.abs(one - two)))
            return f"{how}: {name} at the end differ by {off:.3g}"
    return None


def _of_batch(singles: list[Result], batch: Batch, threads: int) -> str | None:
    for k, one in enumerate(singles):
        how = f"shot {k} of {len(singles)} on {threads} threads"
        n = len(one.scene.balls)
        counts = (batch.ball_ball[k], batch.ball_cushion[k], batch.events[k])
        expected = (*one.collision_counts.values(), one.work["events"])
        if STATUSES[batch.status[k]] is not one.status:
            return f"{how}: {STATUSES[batch.status[k]].name} instead of {one.status.name}"
        if counts != expected:
            return f"{how}: counts {[int(c) for c in counts]} instead of {list(expected)}"
        if batch.rest_times[k] != one.rest_time:
            return f"{how}: ends at {batch.rest_times[k]!r} s instead of {one.rest_time!r} s"
        if not np.array_equal(batch.rest_positions[k, :n], one.rest_positions):
            off = float(np.max(np.abs(batch.rest_positions[k, :n] - one.rest_positions)))
            return f"{how}: positions at the end differ by {off:.3g} m"
        if not np.all(np.isnan(batch.rest_positions[k, n:])):
            return f"{how}: places of balls that it doesn't have"
    return None


def _single_shots(scene: Scene, cue: int, speeds: Any, angles: Any) -> Iterator[Scene]:
    """Yield the scenes of a sweep, computed with the documented arithmetic."""
    shot = scene.balls[cue]
    x, y = shot.velocity[:2]
    scale = max(abs(x), abs(y))
    length = math.sqrt((x / scale) ** 2 + (y / scale) ** 2)
    x, y, first = x / scale / length, y / scale / length, scale * length
    cosines, sines = cosines_and_sines(angles)
    along, across = speeds * cosines, speeds * sines
    turns = cosines * x + sines * y, sines * x - cosines * y
    for speed, vx, vy, c, s in zip(speeds, along, across, *turns, strict=True):
        fields = shot.without_strike().model_dump(exclude_none=True)
        up = speed / first * shot.velocity[2] if shot.velocity[2] != 0.0 else 0.0
        fields["velocity"] = (float(vx), float(vy), float(up))
        if shot.angular_velocity is not None:
            factor = speed / first
            wx, wy, wz = shot.angular_velocity
            spin = (factor * (c * wx - s * wy), factor * (s * wx + c * wy), factor * wz)
            fields["angular_velocity"] = tuple(map(float, spin))
        balls = [*scene.balls]
        balls[cue] = Ball(**fields)
        yield with_balls(scene, balls)


def with_balls(scene: Scene, balls: list[Ball], **others: Any) -> Scene:
    """Return the scene with other balls and, optionally, other changed fields."""
    kept = {name: getattr(scene, name) for name in ("name", "physics", "table", "t_max")}
    return Scene(**{**kept, "balls": tuple(balls), **others})


def _anew(scene: Scene) -> Scene:
    """Return an equal scene without cached values."""
    return with_balls(scene, list(scene.balls))


def _first(found: Iterator[str | None]) -> str | None:
    return next((sentence for sentence in found if sentence is not None), None)
