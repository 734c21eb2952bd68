"""Whether what an engine handed back can be measured: anyone's engine joins, so it is looked at.

This is the one door: `run_engine` in `validation.runs.engine_runs` lets nothing through unseen, and
whoever measures, prints or stores a result may rely on what is checked here. What a function
returns is looked at whole where it becomes a result, whatever part of it is then asked for.
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

MOST = 2**53
"""Largest count: beyond it JSON's readers, whose numbers are doubles, lose ones."""

START_SHARE = 1e-2
"""How far from its place in the scene a ball may be in the first sample, in its radii.

A solver in single precision, or one that settles a ball on its cloth, is off by far less.
"""

LOWEST = 0.5
"""How high the centre of a ball on the cloth is at least, in its radii.

A solver lets balls sink in by hundredths of that; a height of 0 is that of a plane.
"""

_COPY = "Arrays that are changed in place must be copied where they are recorded"

_MEND = "Fix `simulate` of engine `{engine}`; `model.result.Result` documents what it must return"


class ResultRefusedError(Exception):
    """A result that breaks the contract of `Result`: no number of it may be judged."""


def check_result(result: Result, scene: Scene, engine: str, record: Record = "trajectory") -> None:
    """Make sure that a result is one of this scene on this engine, and all of it can be measured.

    Raises `ResultRefusedError` where a field has another type or shape than `Result` says, names
    another engine or scene, counts what can't be counted, or has events that can't have happened. A
    run that says itself that it failed may end anywhere, also at no finite number.
    """
    problem = _problem(result, scene, engine, record)
    if problem:
        said = getattr(result, "reason", "")
        because = f" (message from the engine: {said})" if said else ""
        raise ResultRefusedError(f"{problem}{because}. {_MEND.format(engine=engine)}")


def _problem(result: object, scene: Scene, engine: str, record: Record) -> str:
    """Return the first rule that is broken, with the value received; "" where none is."""
    if not isinstance(result, Result):
        return f"`simulate` must return a `Result`, got {type(result).__name__}"
    if result.engine != engine:
        return f"`engine` of the result must be {engine!r}, got {_shown(result.engine)}"
    if result.scene is not scene and result.scene != scene:
        return (
            f'`scene` of the result must be the scene that was run, "{scene.name}", got another '
            f"one, {getattr(result.scene, 'name', result.scene)!r}"
        )
    if not isinstance(result.status, Status):
        return f"`status` must be a `Status` such as `Status.REST`, got {_shown(result.status)}"
    if not isinstance(result.reason, str):
        return f"`reason` must be a text, got {_shown(result.reason)}"
    looks: tuple[Callable[[], str], ...] = (
        lambda: _of_end(result, scene),
        lambda: _of_numbers(result),
        lambda: _of_counts(result),
        lambda: _of_events(result, scene, record),
        lambda: _of_motion(result, scene, record),
        lambda: disagreement(result, scene),
    )
    return next((problem for look in looks if (problem := look())), "")


def _of_end(result: Result, scene: Scene) -> str:
    """Look at the end of the run: when, and where the balls are."""
    failed = result.status is Status.FAILED
    t = result.rest_time
    if not _is_number(t) or not (failed or (math.isfinite(t) and t >= 0.0)):
        return f"`rest_time` must be finite and at least 0 s, got {_shown(t)}"
    wanted = (1, len(scene.balls), 3)
    if problem := _of_states("final_state", result.final_state, wanted):
        return problem
    positions = result.rest_positions
    lost = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if len(lost) and not failed:
        ball = int(lost[0])
        return (
            f"`rest_positions[{ball}]` must be finite, got {positions[ball].tolist()} "
            f'for ball "{scene.balls[ball].id}"'
        )
    return "" if failed else _of_height(result, scene)


def _of_height(result: Result, scene: Scene) -> str:
    """Look whether balls lie on the cloth and not in it, but for those that left it."""
    events, table = result.events, scene.table
    gone = np.zeros(len(scene.balls), dtype=bool)
    if events is not None and getattr(events, "dtype", None) == EVENT_DTYPE:
        left = np.isin(events["kind"], LEAVING_KINDS)
        gone[[a for a in events["a"][left].tolist() if 0 <= a < len(gone)]] = True
    elif table is not None and (table.holes or scene.physics.airborne):
        gone[:] = True  # nothing says which they are
    heights = result.rest_positions[:, 2]
    below = np.flatnonzero(~gone & (heights < LOWEST * scene.radii))
    if not len(below):
        return ""
    ball = int(below[0])
    radius = float(scene.radii[ball])
    return (
        f"`rest_positions[{ball}][2]` must be the height of the ball's centre over the cloth, "
        f"{radius!r} m where it lies there, and no less than half of that, got "
        f'{float(heights[ball])!r} m for ball "{scene.balls[ball].id}"'
    )


def _of_numbers(result: Result) -> str:
    """Look at what the run says of itself: time, counters, settings."""
    t = result.wall_time
    if not _is_number(t) or not (math.isfinite(t) and t >= 0.0):
        return f"`wall_time` must be finite and at least 0 s, got {_shown(t)}"
    return _of_mapping("work", result.work, _is_count, "a whole number from 0 to 2^53") or (
        _of_mapping(
            "settings",
            result.settings,
            _is_plain,
            "a text, a finite number, a truth value or None",
        )
    )


def _of_mapping(name: str, value: object, allowed: Callable[[object], bool], rule: str) -> str:
    """Look at what must be a mapping of texts to values of a kind."""
    if not isinstance(value, Mapping):
        return f"`{name}` must be a mapping of texts, each to {rule}, got {_shown(value)}"
    for key, one in value.items():
        if not isinstance(key, str):
            return f"`{name}` must have texts as names, got {_shown(key)}"
        if not allowed(one):
            return f"`{name}[{key!r}]` must be {rule}, got {_shown(one)}"
    return ""


def _of_counts(result: Result) -> str:
    """Look at how many collisions there were."""
    counts = result.collision_counts
    kinds = tuple(kind.label for kind in COLLISION_KINDS)
    listed = " and ".join(f'"{kind}"' for kind in kinds)
    if not isinstance(counts, Mapping) or set(counts) != set(kinds):
        return f"`collision_counts` must count {listed}, no more and no less, got {_shown(counts)}"
    for kind in kinds:
        if not _is_count(counts[kind]):
            return (
                f'`collision_counts["{kind}"]` must be a whole number from 0 to 2^53, got '
                f"{_shown(counts[kind])}"
            )
    return ""


def _of_events(result: Result, scene: Scene, record: Record) -> str:
    """Look at the log of events: each possible in this scene, in order, and as many as counted."""
    events = result.events
    if events is None:
        wanted = record != "rest"
        return f'`events` must be there for record="{record}", got None' if wanted else ""
    if not isinstance(events, np.ndarray) or events.dtype != EVENT_DTYPE or events.ndim != 1:
        return (
            "`events` must be an array (k,) of dtype `EVENT_DTYPE`, with the fields t, kind, a and "
            f"b, got {_shown(events)}"
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
                f'`collision_counts["{kind.label}"]` must be the number of such events, '
                f"{logged}, got {result.collision_counts[kind.label]}"
            )
    return ""


def _rules_of_events(result: Result, scene: Scene) -> Iterator[tuple[str, Any, str]]:
    """Yield the field that a rule is about, where it is broken (k,), and the rule."""
    events, n = result.events, len(scene.balls)
    assert events is not None
    t, kind, a, b = (events[field] for field in ("t", "kind", "a", "b"))
    yield "t", ~np.isfinite(t), "finite"
    yield "t", t < 0.0, "at least 0 s, when the shot starts"
    if result.status is not Status.FAILED:
        end = float(result.rest_time)
        yield "t", t > end, f"at most {end!r} s, when the run ended (`rest_time`)"
    yield "t", np.diff(t, prepend=-np.inf) < 0.0, "no earlier than that of the event before"
    kinds = ", ".join(f"{one.value} ({one.label})" for one in EventKind)
    yield "kind", ~np.isin(kind, [one.value for one in EventKind]), f"one of {kinds}"
    balls = f"the index of a ball, from 0 to {n - 1}"
    yield "a", (a < 0) | (a >= n), balls
    of_balls = kind == EventKind.BALL_BALL
    of_cushion = kind == EventKind.BALL_CUSHION
    yield "b", of_balls & ((b < 0) | (b >= n)), balls
    yield "b", of_balls & (a == b), "another ball than a"
    partners = partners_of(scene.table)
    for of, one, what in (
        (of_cushion, EventKind.BALL_CUSHION, "cushion"),
        (kind == EventKind.LEAVES_TABLE, EventKind.LEAVES_TABLE, "cushion"),
        (kind == EventKind.POCKETED, EventKind.POCKETED, "pocket"),
    ):
        yield "b", of & ~np.isin(b, partners[one]), _rule(what, one, partners[one])
    alone = ~(of_balls | np.isin(kind, list(partners)))
    yield "b", alone & (b != -1), "-1, for a ball alone"


def partners_of(table: Table | None) -> dict[EventKind, list[int]]:
    """Return what events of a ball and an obstacle, or a pocket, may name of a table, by kind."""
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


def _of_motion(result: Result, scene: Scene, record: Record) -> str:
    """Look at what can be sampled."""
    motion = result.trajectory
    if motion is None:
        wanted = record == "trajectory"
        return '`trajectory` must be there for record="trajectory", got None' if wanted else ""
    if not isinstance(motion, SampledTrajectory):
        lacks = [name for name in ("sample", "t_end") if not hasattr(motion, name)]
        named = " and ".join(f"`{name}`" for name in lacks)
        return f"`trajectory` must be a `Trajectory`: {_shown(motion)} lacks {named}" * bool(lacks)
    times = motion.times
    if not isinstance(times, np.ndarray) or times.ndim != 1 or not len(times):
        return f"`trajectory.times` must be an array (k,), got {_shown(times)}"
    if not np.isfinite(times).all() or (np.diff(times) < 0.0).any():
        return "`trajectory.times` must be finite and never decrease"
    shape = (len(times), len(scene.balls), 3)
    return _of_states("trajectory", motion, shape) or _of_start(motion, scene)


def _of_start(motion: SampledTrajectory, scene: Scene) -> str:
    """Look whether the motion begins as the scene does.

    It doesn't where it is of another scene, or where an engine that changes its arrays in place
    handed over the arrays themselves: then all of its samples show the end.
    """
    if motion.times[0] != 0.0:
        return f"`trajectory` must begin at t = 0, got {float(motion.times[0])!r} s"
    off = np.linalg.norm(motion.positions[0] - scene.positions, axis=1)
    away = np.flatnonzero(~(off <= START_SHARE * scene.radii))
    if len(away):
        ball = int(away[0])
        return (
            f'`trajectory` must begin as the scene does, with ball "{scene.balls[ball].id}" at '
            f"{scene.positions[ball].tolist()}, got {motion.positions[0, ball].tolist()}. {_COPY}"
        )
    if scene.velocities.any() and not motion.velocities[0].any():
        return f"`trajectory` must begin as the scene does, got balls at rest at t = 0. {_COPY}"
    return ""


def _of_states(where: str, states: object, shape: tuple[int, ...]) -> str:
    """Look at positions, velocities and angular velocities."""
    for name in Samples._fields:
        array = getattr(states, name, None)
        if not isinstance(array, np.ndarray) or array.dtype.kind != "f" or array.shape != shape:
            return (
                f"`{where}.{name}` must be an array of floats with shape {shape}, got "
                f"{_shown(array)}"
            )
    return ""


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool | np.bool_)


def _is_count(value: object) -> bool:
    whole = isinstance(value, Integral) and not isinstance(value, bool | np.bool_)
    return whole and 0 <= int(value) <= MOST  # type: ignore[call-overload]


def _is_plain(value: object) -> bool:
    if isinstance(value, float):
        return math.isfinite(value)
    return isinstance(value, str | int | None)


def _shown(value: object) -> str:
    """Return a value for a message, with its type where that says more than its text."""
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype} with shape {value.shape}"
    if value is None or isinstance(value, bool | int | float | str):
        return f"{value!r:.100}" + (" (a text)" if isinstance(value, str) else "")
    return f"{value!r:.100} ({type(value).__name__})"
