"""Read and write the JSON files of pooltool: `System.save("shot.json")` of version 0.6.

The long side of a table is along y in pooltool and along x in Ghostball: the scene is turned by a
right angle. A file holds no laws of impacts, so a scene gets those of pooltool's default engine:
Alciatore's friction of balls, and Stronge's cushion. The scene is the start of the shot, even if
pooltool has simulated it. A stroke with an elevated cue differs, because pooltool neglects the
impulse of the table; and the facing of a side pocket is tangent to its jaw here, but turned by
0.06 degrees in pooltool.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from ghostball.model import GhostballError, Scene
from ghostball.model.scene.obstacles import Disc, Hole, Segment
from ghostball.model.scene.pockets import Pocket, Pockets, obstacles_of_pockets
from ghostball.model.scene.sides import CUSHIONS
from ghostball.model.text_files import read_text

FREQUENCY_RATIO = 1.8
"""Frequency ratio of Stronge's cushion in pooltool's default."""

LEAST_FRICTION = 1e-9
"""Coefficient that is written for a friction of 0, which pooltool rejects."""

_SAME = 1e-9
"""Largest difference of two positions that count as equal [m]."""

_SPACING = 1e-6
"""Distance by which pooltool moves a ball away from what it hits [m]."""

_LARGEST_RADIUS = 0.2
"""Largest radius of a ball [m]; a larger number isn't in metres."""

_TIP_FRICTION = 10.0
"""Friction of the tip: pooltool has no miscues, so nearly all offsets are allowed."""

_RESTING, _SLIDING, _ROLLING = 0, 2, 3
"""pooltool's numbers of the states of a ball."""

_BOTH_SIDES = 2
"""pooltool's number for a cushion that balls may touch from both sides."""

Vector = tuple[float, float, float]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore", allow_inf_nan=False, defer_build=True)


class _State(_Part):
    rvw: tuple[Vector, Vector, Vector]


class _Params(_Part):
    m: float
    R: float = Field(le=_LARGEST_RADIUS)
    u_s: float
    u_r: float
    u_sp_proportionality: float
    e_b: float
    e_c: float
    f_c: float
    g: float


class _History(_Part):
    states: tuple[_State, ...]


class _Ball(_Part):
    state: _State
    params: _Params
    history: _History

    @property
    def start(self) -> tuple[Vector, Vector, Vector]:
        return (self.history.states or (self.state,))[0].rvw


class _Specs(_Part):
    M: float
    end_mass: float


class _Cue(_Part):
    V0: float
    phi: float
    theta: float
    a: float
    b: float
    cue_ball_id: str
    specs: _Specs = Field(  # pooltool's defaults
        default_factory=lambda: _Specs(M=0.567, end_mass=0.170097 / 30)
    )


class _Linear(_Part):
    p1: Vector
    p2: Vector


class _Round(_Part):
    center: Vector
    radius: float


class _Cushions(_Part):
    linear: dict[str, _Linear] = Field(min_length=4)
    circular: dict[str, _Round]


class _Table(_Part):
    cushion_segments: _Cushions
    pockets: dict[str, _Round]


class _System(_Part):
    cue: _Cue
    table: _Table
    balls: dict[str, _Ball] = Field(min_length=1)


def load_pooltool(path: Path) -> Scene:
    """Read a scene from a JSON file of pooltool.

    Raises `GhostballError` if the file isn't a shot of pooltool, or if Ghostball doesn't support
    its table.
    """
    try:
        system = _System.model_validate_json(read_text(path))
        return _scene_of(system, path.stem)
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(map(str, first["loc"])) or "the file"
        why = f"`{field}`: {first['msg'].lower()}"
    except (OSError, UnicodeDecodeError, GhostballError) as error:
        why = str(error)
    raise GhostballError(
        f"{path} can't be read as a shot of pooltool 0.6, in metres: {why}. Save it with "
        '`system.save("shot.json")`'
    )


def _scene_of(system: _System, name: str) -> Scene:
    length, width, height, pockets = _table_of(system.table)
    first = next(iter(system.balls.values())).params
    strikes = not any(any(v) or any(w) for _, v, w in (b.start for b in system.balls.values()))
    balls: list[dict[str, Any]] = []
    for key, ball in system.balls.items():
        p = ball.params
        (x, y, z), (vx, vy, vz), (wx, wy, wz) = ball.start
        one: dict[str, Any] = {
            "id": key,
            "position": (y, width - x, z),
            "velocity": (vy, -vx, vz),
            "angular_velocity": (wy, -wx, wz),
            "radius": p.R,
            "mass": p.m,
        }
        if p != first:
            one |= _frictions_of(p)
        if strikes and key == system.cue.cue_ball_id and system.cue.V0 > 0.0:
            del one["velocity"], one["angular_velocity"]
            one["strike"] = _strike_of(system.cue)
        balls.append(one)
    physics = {
        "motion": "sliding",
        "gravity": first.g,
        "ball_restitution": first.e_b,
        "ball_friction": "alciatore",
        "cushion": "stronge2000",
        "cushion_frequency_ratio": FREQUENCY_RATIO,
        "cushion_restitution": first.e_c,
        "cushion_friction": first.f_c,
        "cushion_height": first.R * (1.0 + _sine(height - first.R, first.R + _SPACING)),
        **_frictions_of(first),
    }
    table: dict[str, Any] = {"length": length, "width": width}
    if pockets is not None:
        table["pockets"] = pockets.model_dump()
    fields = {"name": name, "title": f"pooltool: {name}", "balls": balls}
    return Scene.model_validate({**fields, "physics": physics, "table": table})


def _frictions_of(params: _Params) -> dict[str, float]:
    # The deceleration of spin is 5 u_sp g / (2 R), and u_sp = R times this.
    rate = 2.5 * params.u_sp_proportionality * params.g
    return {
        "sliding_friction": params.u_s,
        "rolling_friction": params.u_r,
        "spinning_friction_rate": rate,
    }


def _sine(opposite: float, adjacent: float) -> float:
    """Return the sine of the angle with these sides; see `_height_for_pooltool`."""
    return opposite / math.hypot(opposite, adjacent)


def _height_for_pooltool(scene: Scene) -> float:
    """Return the height of the nose that gives Stronge's cushion the same normal in pooltool [m].

    The sine of the normal's elevation is (height - R) / R here. In pooltool, the normal points from
    the nose to the centre of the ball, which is `_SPACING` more than R beside the nose.
    """
    radius, height = float(scene.radii[0]), scene.physics.cushion_height
    if scene.physics.cushion != "stronge2000":
        return height
    sine = (height - radius) / radius
    return radius + (radius + _SPACING) * sine / math.sqrt(1.0 - sine * sine)


def _strike_of(cue: _Cue) -> dict[str, Any]:
    turned = math.radians(cue.phi - 90.0)
    return {
        "speed": cue.V0,
        "direction": math.remainder(turned, 2.0 * math.pi),
        "elevation": math.radians(cue.theta),
        "offset_left": cue.a,
        "offset_up": cue.b,
        "cue_mass": cue.specs.M,
        "tip_restitution": 1.0,
        "tip_friction": _TIP_FRICTION,
        "squirt": "alciatore",
        "end_mass": cue.specs.end_mass,
    }


def _table_of(table: _Table) -> tuple[float, float, float, Pockets | None]:
    """Return length, width and nose height of a table [m], and its pockets.

    Raises `GhostballError` if it is no rectangle, or has pockets of another shape.
    """
    linear, discs = table.cushion_segments.linear, table.cushion_segments.circular
    ends = [(one.p1, one.p2) for one in linear.values()]
    width = max((p[0] for p, q in ends if p[0] == q[0]), default=0.0)
    length = max((p[1] for p, q in ends if p[1] == q[1]), default=0.0)
    height = ends[0][0][2]
    edges = [p[0] == q[0] in (0.0, width) or p[1] == q[1] in (0.0, length) for p, q in ends]
    if all(edges) and len(ends) == 4 and not discs and not table.pockets:
        return length, width, height, None
    facings = [pair for pair, is_rail in zip(ends, edges, strict=True) if not is_rail]
    try:
        pockets = _pockets_of([*discs.values()], facings, [*table.pockets.values()], length)
    except (ValueError, ZeroDivisionError, GhostballError):
        raise _other_shape() from None
    found = obstacles_of_pockets(length, width, pockets)
    ours = [(one.centre, one.radius) for one in found if isinstance(one, Disc | Hole)]
    theirs = [
        ((one.center[1], width - one.center[0]), one.radius)
        for one in (*discs.values(), *table.pockets.values())
    ]
    if len(ours) != len(theirs) or not all(_among(one, ours) for one in theirs):
        raise _other_shape()
    return length, width, height, pockets


def _pockets_of(
    jaws: Sequence[_Round],
    facings: Sequence[tuple[Vector, Vector]],
    holes: Sequence[_Round],
    length: float,
) -> Pockets:
    """Return the pockets of a table from those at (0, 0) and (0, length / 2)."""

    def facing_of(jaw: _Round) -> tuple[Vector, Vector]:
        """Return the end of the facing at its jaw, and the other end."""
        ends = [(p, q) for pair in facings for p, q in (pair, pair[::-1])]
        return min(ends, key=lambda pair: math.dist(pair[0], jaw.center))

    jaw = min((one for one in jaws if one.center[1] < 0.0), key=lambda one: one.center[0])
    end, far = facing_of(jaw)
    angle = math.atan2(end[0] - far[0], end[1] - far[1])
    back = jaw.radius / math.tan(0.5 * (0.5 * math.pi + angle))
    mouth = math.sqrt(2.0) * (jaw.center[0] - back)
    hole = min(holes, key=lambda one: math.dist(one.center, (0.0, 0.0, 0.0)))
    corner = Pocket(
        mouth=mouth,
        angle=0.5 * math.pi + angle,
        jaw_radius=jaw.radius,
        depth=0.5 * mouth - math.sqrt(2.0) * hole.center[0] - hole.radius,
        radius=hole.radius,
    )
    # The end of the jaw is at (-d cos(s), c - d (1 + sin(s))), if c is the height of its centre.
    beyond = (one for one in jaws if one.center[0] < 0.0 and 2.0 * one.center[1] > length)
    jaw = min(beyond, key=lambda one: one.center[1])
    end, _ = facing_of(jaw)
    angle = 2.0 * math.atan2(jaw.center[1] - end[1], -end[0]) - 0.5 * math.pi
    back = jaw.radius / math.tan(0.5 * (0.5 * math.pi + angle))
    hole = min(holes, key=lambda one: math.dist(one.center, (0.0, 0.5 * length, 0.0)))
    side = Pocket(
        mouth=2.0 * (jaw.center[1] - back) - length,
        angle=0.5 * math.pi + angle,
        jaw_radius=jaw.radius,
        depth=-hole.center[0] - hole.radius,
        radius=hole.radius,
    )
    return Pockets(corner=corner, side=side)


def _among(
    one: tuple[tuple[float, float], float], others: Sequence[tuple[tuple[float, float], float]]
) -> bool:
    """Return True if a circle equals one of the circles `others`, up to `_SAME`."""
    (x, y), r = one
    return any(max(abs(x - u), abs(y - v), abs(r - radius)) <= _SAME for (u, v), radius in others)


def _other_shape() -> GhostballError:
    return GhostballError("its table is neither a rectangle nor one of pooltool's pocket tables")


def pooltool_json(scene: Scene) -> str:
    """Return a scene as a JSON file of pooltool, which `pooltool.System.load` reads.

    Only the state at the start is written: strikes become velocities, and `t_max` is left out. The
    laws of impacts are those of the engine that pooltool is told to use.

    Raises `GhostballError` if the scene has physics or a table that pooltool doesn't have.
    """
    if why := _unknown_to_pooltool(scene):
        raise GhostballError(f'scene "{scene.name}" can\'t be written for pooltool: {why}')
    assert scene.table is not None
    size, physics = scene.table.width, scene.physics
    friction, spins_by = physics.ball_friction, scene.spinning_friction_rates.tolist()
    balls: dict[str, Any] = {}
    for k, ball in enumerate(scene.balls):
        vectors = (scene.positions[k], scene.velocities[k], scene.angular_velocities[k])
        (x, y, z), v, w = (one.tolist() for one in vectors)
        rolling = abs(w[0] * ball.radius + v[1]) + abs(w[1] * ball.radius - v[0]) == 0.0
        moves = any(v) or any(w)
        state = {
            "rvw": [[size - y, x, z], [-v[1], v[0], v[2]], [-w[1], w[0], w[2]]],
            "s": _RESTING if not moves else _ROLLING if rolling and any(v) else _SLIDING,
            "t": 0.0,
        }
        params = {
            "m": ball.mass,
            "R": ball.radius,
            "u_s": max(float(scene.sliding_frictions[k]), LEAST_FRICTION),
            "u_r": max(float(scene.rolling_frictions[k]), LEAST_FRICTION),
            "u_sp_proportionality": max(0.4 * spins_by[k] / physics.gravity, LEAST_FRICTION),
            "u_b": max(friction, LEAST_FRICTION) if isinstance(friction, float) else 0.05,
            "e_b": physics.ball_restitution,
            "e_c": physics.cushion_restitution,
            "f_c": max(physics.cushion_friction, LEAST_FRICTION),
            "g": physics.gravity,
        }
        balls[ball.id] = {
            "id": ball.id,
            "state": state,
            "params": params,
            "ballset": None,
            "initial_orientation": {"pos": [1.0, 1.0, 1.0, 1.0], "sphere": [1.0, 0.0, 0.0, 0.0]},
            "history": {"states": []},
            "history_cts": {"states": []},
        }
    cue = {"id": "cue_stick", "V0": 0.0, "phi": 0.0, "theta": 0.0, "a": 0.0, "b": 0.0}
    cue |= {"cue_ball_id": scene.balls[0].id}
    system = {"cue": cue, "table": _written_table(scene), "balls": balls, "t": 0.0, "events": []}
    return json.dumps(system, indent=1) + "\n"


def _written_table(scene: Scene) -> dict[str, Any]:
    assert scene.table is not None
    width, height = scene.table.width, _height_for_pooltool(scene)
    linear: dict[str, Any] = {}
    discs: dict[str, Any] = {}
    holes: dict[str, Any] = {}
    sides = [Segment(one.cushion, *one.ends()) for one in scene.table.sides]
    for k, one in enumerate((*sides, *scene.table.obstacles)):
        name = str(k)
        if isinstance(one, Segment):
            ends = ([width - y, x, height] for x, y in (one.start, one.end))
            linear[name] = dict(zip(("p1", "p2"), ends, strict=True))
            linear[name] |= {"id": name, "direction": _BOTH_SIDES}
        elif isinstance(one, Disc):
            place = [width - one.centre[1], one.centre[0], height]
            discs[name] = {"id": name, "center": place, "radius": one.radius}
        else:
            place = [width - one.centre[1], one.centre[0], 0.0]
            holes[name] = {"id": name, "center": place, "radius": one.radius}
            holes[name] |= {"depth": 0.08, "contains": []}
    return {
        "cushion_segments": {"linear": linear, "circular": discs},
        "pockets": holes,
        "table_type": "pocket" if holes else "billiard",
    }


def _unknown_to_pooltool(scene: Scene) -> str:
    """Return what pooltool doesn't have, or ""."""
    physics, table = scene.physics, scene.table
    if table is None or table.vertices or table.posts or len(table.cushions) < len(CUSHIONS):
        return "it needs a rectangular table with four cushions, and without posts"
    if physics.motion != "sliding":
        return '`motion` must be "sliding"'
    if physics.air_drag or physics.rolling_friction_quadratic or physics.airborne:
        return "pooltool has no air and no flight"
    if len(set(scene.radii.tolist())) > 1 or len(set(scene.masses.tolist())) > 1:
        return "its balls must have equal radii and masses"
    return ""
