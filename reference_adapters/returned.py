"""Check that the result of an engine is valid, because anyone's engine may be tested.

`run_engine` in `validation.runs.engine_runs` calls this module for every result, so that all code
that judges, prints or stores a result may rely on these checks. The result of a function is always
checked completely, even if only parts of it are needed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from numbers import Integral, Real
from typing import Any

import numpy as np

from ghostball.model import (
    COLLISION_KINDS,
    EVENT_DTYPE,
    EventKind,
    Hole,
    Record,
    Result,
    SampledTrajectory,
    Samples,
    Scene,
    Status,
    Table,
    partner_name,
)
from ghostball.model.events import LEAVING_KINDS
from ghostball.model.scene.obstacles import FIRST_HOLE
from ghostball.reference_adapters.agreement import disagreement

MAX_COUNT = 2**53
"""Largest count: JSON readers use doubles, which can't represent all larger integers."""

START_TOLERANCE = 1e-2
"""Largest distance of a ball from its initial position in the first sample, in radii.

A single-precision solver, or a solver in which a ball settles on the cloth, is far more accurate.
"""

LOWEST_CENTRE = 0.5
"""Smallest height of the centre of a ball on the cloth, in radii.

In a solver, balls sink in by hundredths of a radius; a height of 0 is that of a 2D engine.
"""

_COPY_HINT = "If the engine changes arrays in place, it must copy them when it records them"

_FIX_HINT = (
    "Fix `simulate` of engine `{engine}`; `model.result.Result` documents what it must return"
)


class ResultRefusedError(Exception):
    """A result that breaks the contract of `Result`: none of its numbers can be judged."""


def check_result(result: Result, scene: Scene, engine: str, record: Record = "trajectory") -> None:
    """Check that a result belongs to this scene and engine, and that everything can be measured.

    Raises `ResultRefusedError` if a field has a type or a shape that `Result` doesn't allow, if the
    result names a different engine or scene, if a count is invalid, or if an event is impossible. A
    run with the status FAILED may end anywhere, even at positions that aren't finite.
    """
    problem = _problem(result, scene, engine, record)
    if problem:
        said = getattr(result, "reason", "")
        because = f" (message from the engine: {said})" if said else ""
        raise ResultRefusedError(f"{problem}{because}. {_FIX_HINT.format(engine=engine)}")


def _problem(result: object, scene: Scene, engine: str, record: Record) -> str:
    """Return the first broken rule, with the value received; "" if there is none."""
    if not isinstance(result, Result):
        return f"`simulate` must return a `Result`, got {type(result).__name__}"
    if result.engine != engine:
        return f"`engine` of the result must be {engine!r}, got {shown(result.engine)}"
    if result.scene is not scene and result.scene != scene:
        return (
            f'`scene` of the result must be the scene that was run, "{scene.name}", got a '
            f"different scene, {getattr(result.scene, 'name', result.scene)!r}"
        )
    if not isinstance(result.status, Status):
        return f"`status` must be a `Status` such as `Status.REST`, got {shown(result.status)}"
    if not isinstance(result.reason, str):
        return f"`reason` must be text, got {shown(result.reason)}"
    looks: tuple[Callable[[], str], ...] = (
        lambda: _end_problem(result, scene),
        lambda: _number_problem(result),
        lambda: _count_problem(result),
        lambda: _event_problem(result, scene, record),
        lambda: _motion_problem(result, scene, record),
        lambda: disagreement(result, scene),
    )
    return next((problem for look in looks if (problem := look())), "")


def _end_problem(result: Result, scene: Scene) -> str:
    """Check the end of the run: time and positions."""
    failed = result.status is Status.FAILED
    t = result.rest_time
    if not _is_number(t) or not (failed or (math.isfinite(t) and t >= 0.0)):
        return f"`rest_time` must be finite and at least 0 s, got {shown(t)}"
    wanted = (1, len(scene.balls), 3)
    if problem := _state_problem("final_state", result.final_state, wanted):
        return problem
    positions = result.rest_positions
    lost = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if len(lost) and not failed:
        ball = int(lost[0])
        return (
            f"`rest_positions[{ball}]` must be finite, got {positions[ball].tolist()} "
            f'for ball "{scene.balls[ball].id}"'
        )
    return "" if failed else _height_problem(result, scene)


def _height_problem(result: Result, scene: Scene) -> str:
    """Check that no ball is below the cloth, except balls that left the table."""
    events, table = result.events, scene.table
    gone = np.zeros(len(scene.balls), dtype=bool)
    if events is not None and getattr(events, "dtype", None) == EVENT_DTYPE:
        left = np.isin(events["kind"], LEAVING_KINDS)
        gone[[a for a in events["a"][left].tolist() if 0 <= a < len(gone)]] = True
    elif table is not None and (table.holes or scene.physics.airborne):
        gone[:] = True  # unknown which balls left
    heights = result.rest_positions[:, 2]
    below = np.flatnonzero(~gone & (heights < LOWEST_CENTRE * scene.radii))
    if not len(below):
        return ""
    ball = int(below[0])
    radius = float(scene.radii[ball])
    return (
        f"`rest_positions[{ball}][2]` must be the height of the ball's centre above the cloth, "
        f"{radius!r} m for a ball on the cloth and at least half of that, got "
        f'{float(heights[ball])!r} m for ball "{scene.balls[ball].id}"'
    )


def _number_problem(result: Result) -> str:
    """Check run time, counters and settings."""
    t = result.wall_time
    if not _is_number(t) or not (math.isfinite(t) and t >= 0.0):
        return f"`wall_time` must be finite and at least 0 s, got {shown(t)}"
    return _mapping_problem("work", result.work, _is_count, "a whole number from 0 to 2^53") or (
        _mapping_problem(
            "settings",
            result.settings,
            _is_plain,
            "text, a finite number, True, False or None",
        )
    )


def _mapping_problem(name: str, value: object, allowed: Callable[[object], bool], rule: str) -> str:
    """Check a value that must be a mapping of texts to allowed values."""
    if not isinstance(value, Mapping):
        return f"`{name}` must map texts to {rule}, got {shown(value)}"
    for key, one in value.items():
        if not isinstance(key, str):
            return f"`{name}` must have texts as keys, got {shown(key)}"
        if not allowed(one):
            return f"`{name}[{key!r}]` must be {rule}, got {shown(one)}"
    return ""


def _count_problem(result: Result) -> str:
    """Check the numbers of collisions."""
    counts = result.collision_counts
    kinds = tuple(kind.label for kind in COLLISION_KINDS)
    listed = " and ".join(f'"{kind}"' for kind in kinds)
    if not isinstance(counts, Mapping) or set(counts) != set(kinds):
        return f"`collision_counts` must have exactly the keys {listed}, got {shown(counts)}"
    for kind in kinds:
        if not _is_count(counts[kind]):
            return (
                f'`collision_counts["{kind}"]` must be a whole number from 0 to 2^53, got '
                f"{shown(counts[kind])}"
            )
    return ""


def _event_problem(result: Result, scene: Scene, record: Record) -> str:
    """Check the event log: possible events, in order, and as many as counted."""
    events = result.events
    if events is None:
        wanted = record != "rest"
        return f'`events` must be given for record="{record}", got None' if wanted else ""
    if not isinstance(events, np.ndarray) or events.dtype != EVENT_DTYPE or events.ndim != 1:
        return (
            "`events` must be an array (k,) of dtype `EVENT_DTYPE`, with the fields t, kind, a and "
            f"b, got {shown(events)}"
        )
    for field, wrong, rule in _rules_of_events(result, scene):
        where = np.flatnonzero(wrong)
        if len(where):
            k = int(where[0])
            return f"`events[{k}].{field}` must be {rule}, got {events[k][field].item()!r}"
    for kind in COLLISION_KINDS:
        logged = int(np.count_nonzero(events["kind"] == kind))
        if logged != result.collision_counts[kind.label]:
            return (
                f'`collision_counts["{kind.label}"]` must be the number of these events, '
                f"{logged}, got {result.collision_counts[kind.label]}"
            )
    return ""


def _rules_of_events(result: Result, scene: Scene) -> Iterator[tuple[str, Any, str]]:
    """Yield each rule: its field, an array (k,) that is True where it is broken, its text."""
    events, n = result.events, len(scene.balls)
    assert events is not None
    t, kind, a, b = (events[field] for field in ("t", "kind", "a", "b"))
    yield "t", ~np.isfinite(t), "finite"
    yield "t", t < 0.0, "at least 0 s, when the shot starts"
    if result.status is not Status.FAILED:
        end = float(result.rest_time)
        yield "t", t > end, f"at most {end!r} s, when the run ended (`rest_time`)"
    yield "t", np.diff(t, prepend=-np.inf) < 0.0, "no earlier than the previous event"
    kinds = ", ".join(f"{one.value} ({one.label})" for one in EventKind)
    yield "kind", ~np.isin(kind, [one.value for one in EventKind]), f"one of {kinds}"
    balls = f"the index of a ball, from 0 to {n - 1}"
    yield "a", (a < 0) | (a >= n), balls
    of_balls = kind == EventKind.BALL_BALL
    of_cushion = kind == EventKind.BALL_CUSHION
    yield "b", of_balls & ((b < 0) | (b >= n)), balls
    yield "b", of_balls & (a == b), "a different ball from a"
    partners = partners_of(scene.table)
    for of, one, what in (
        (of_cushion, EventKind.BALL_CUSHION, "cushion"),
        (kind == EventKind.LEAVES_TABLE, EventKind.LEAVES_TABLE, "cushion"),
        (kind == EventKind.POCKETED, EventKind.POCKETED, "pocket"),
    ):
        yield "b", of & ~np.isin(b, partners[one]), _rule(what, one, partners[one])
    alone = ~(of_balls | np.isin(kind, list(partners)))
    yield "b", alone & (b != -1), "-1 for an event of a single ball"


def partners_of(table: Table | None) -> dict[EventKind, list[int]]:
    """Return the indices of obstacles and pockets of a table that events may name, by kind."""
    others = () if table is None else table.obstacles
    cushions = {side.cushion for side in (() if table is None else table.sides)}
    cushions |= {one.obstacle for one in others if not isinstance(one, Hole)}
    pockets = [one.pocket for one in others if isinstance(one, Hole)]
    return {
        EventKind.BALL_CUSHION: sorted(cushions),
        EventKind.POCKETED: pockets,
        EventKind.LEAVES_TABLE: [*sorted(cushions), *(FIRST_HOLE + one for one in pockets)],
    }


def _rule(what: str, kind: EventKind, indices: list[int]) -> str:
    listed = ", ".join(f"{index} ({partner_name(kind, index)})" for index in indices)
    return f"the index of an existing {what}: {listed or 'this scene has none'}"


def _motion_problem(result: Result, scene: Scene, record: Record) -> str:
    """Check the recorded motion."""
    motion = result.trajectory
    if motion is None:
        wanted = record == "trajectory"
        return '`trajectory` must be given for record="trajectory", got None' if wanted else ""
    if not isinstance(motion, SampledTrajectory):
        lacks = [f"`{name}`" for name in ("sample", "t_end") if not hasattr(motion, name)]
        if not lacks:
            return ""
        return f"`trajectory` must be a `Trajectory`: {shown(motion)} lacks {' and '.join(lacks)}"
    times = motion.times
    if not isinstance(times, np.ndarray) or times.ndim != 1 or not len(times):
        return f"`trajectory.times` must be an array (k,), got {shown(times)}"
    if not np.isfinite(times).all() or (np.diff(times) < 0.0).any():
        return "`trajectory.times` must be finite and never decrease"
    shape = (len(times), len(scene.balls), 3)
    return _state_problem("trajectory", motion, shape) or _start_problem(motion, scene)


def _start_problem(motion: SampledTrajectory, scene: Scene) -> str:
    """Check that the motion starts from the initial state of the scene.

    A motion starts elsewhere if it belongs to a different scene, or if the engine returned arrays
    that it changes in place: then all samples show the end.
    """
    if motion.times[0] != 0.0:
        return f"`trajectory` must start at t = 0, got {float(motion.times[0])!r} s"
    off = np.linalg.norm(motion.positions[0] - scene.positions, axis=1)
    away = np.flatnonzero(~(off <= START_TOLERANCE * scene.radii))
    if len(away):
        ball = int(away[0])
        return (
            "`trajectory` must start from the scene's initial state, with ball "
            f'"{scene.balls[ball].id}" at {scene.positions[ball].tolist()}, got '
            f"{motion.positions[0, ball].tolist()}. {_COPY_HINT}"
        )
    if scene.velocities.any() and not motion.velocities[0].any():
        return (
            "`trajectory` must start from the scene's initial state, got balls at rest at t = 0. "
            f"{_COPY_HINT}"
        )
    return ""


def _state_problem(where: str, states: object, shape: tuple[int, ...]) -> str:
    """Check positions, velocities and angular velocities."""
    for name in Samples._fields:
        array = getattr(states, name, None)
        if not isinstance(array, np.ndarray) or array.dtype.kind != "f" or array.shape != shape:
            return (
                f"`{where}.{name}` must be an array of floats with shape {shape}, got "
                f"{shown(array)}"
            )
    return ""


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool | np.bool_)


def _is_count(value: object) -> bool:
    whole = isinstance(value, Integral) and not isinstance(value, bool | np.bool_)
    return whole and 0 <= int(value) <= MAX_COUNT  # type: ignore[call-overload]


def _is_plain(value: object) -> bool:
    if isinstance(value, float):
        return math.isfinite(value)
    return isinstance(value, str | int | None)


def shown(value: object) -> str:
    """Return a value for a message, with its type if that is informative."""
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype} with shape {value.shape}"
    if value is None or isinstance(value, bool | int | float | str):
        return f"{value!r:.100}" + (" (text)" if isinstance(value, str) else "")
    return f"{value!r:.100} ({type(value).__name__})"
