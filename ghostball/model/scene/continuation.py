"""The fields of a scene that continues another scene: the next shot, or a later time."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Any, Protocol, runtime_checkable

import numpy as np

from ghostball.model.arrays import BoolArray, FloatArray
from ghostball.model.events import Status
from ghostball.model.rounding import position_rounding
from ghostball.model.scene.contents import SceneContents
from ghostball.model.scene.messages import refusal
from ghostball.model.scene.obstacles import Disc, Hole, gap_to, is_inside

Change = Mapping[str, Any]
"""Fields of a ball by name."""

_MOTION = ("position", "velocity", "angular_velocity", "strike")
_NAME = re.compile(r"(?P<shot>.*?)(?:\.(?P<number>[0-9]{1,9}))?")
_LONGEST_NAME = 64


@runtime_checkable
class EndedShot(Protocol):
    """A simulated shot: the fields of a `Result` that `Scene.after` needs."""

    @property
    def engine(self) -> str:
        """Name of the engine."""
        ...

    @property
    def scene(self) -> SceneContents:
        """The scene that was simulated."""
        ...

    @property
    def status(self) -> Status:
        """How the run ended."""
        ...

    @property
    def rest_positions(self) -> FloatArray:
        """Centres at the end of the run, (n, 3) [m]."""
        ...

    @property
    def gone(self) -> BoolArray:
        """Which balls were pocketed or left the table, (n,)."""
        ...


def fields_after(shot: EndedShot, changes: Mapping[str, Change]) -> dict[str, Any]:
    """Return the fields of the scene that follows a shot; see `Scene.after`.

    Raises `SceneError` if there is no such scene.
    """
    if not isinstance(shot, EndedShot):
        raise refusal(
            f"`result` must be a Result, got {type(shot).__name__}. Give what `simulate` returns"
        )
    scene = shot.scene
    if shot.status is not Status.REST:
        raise refusal(
            f'the result of scene "{scene.name}" must be at rest, but the run ended with status '
            f"{shot.status.name}. Simulate until all balls are at rest, or use `result.at(t)`"
        )
    ids = [ball.id for ball in scene.balls]
    if len(shot.rest_positions) != len(ids):
        raise refusal(
            f"`rest_positions` of the result must have {len(ids)} rows, one per ball of scene "
            f'"{scene.name}", got {len(shot.rest_positions)}. Give a result with the scene that '
            "was simulated"
        )
    if not isinstance(changes, Mapping) or not all(
        isinstance(change, Mapping) for change in changes.values()
    ):
        raise refusal(
            f"`changes` must map ball ids to fields, got {repr(changes)[:80]}. Give "
            '{"ID": {"velocity": (1.0, 0.0)}}'
        )
    for name in changes:
        if name not in ids:
            close = get_close_matches(str(name), ids, n=1)
            known = f'Did you mean "{close[0]}"?' if close else f"Balls: {', '.join(ids)}"
            raise refusal(
                f'`changes` must name balls of scene "{scene.name}", got {name!r}. {known}'
            )
    balls = []
    for i, ball in enumerate(_balls_at(scene, shot.rest_positions)):
        change = changes.get(ids[i], {})
        if shot.gone[i] and change and "position" not in change:
            raise refusal(
                f'`changes["{ids[i]}"]` must have a `position`: the ball was pocketed, or left the '
                "table. Give the place where it is put, or remove the change"
            )
        if not shot.gone[i] or change:
            balls.append({**ball, **change})
    if not balls:
        raise refusal(
            f'the scene after "{scene.name}" must have a ball, but none is left on the table. Put '
            'one there: changes={"ID": {"position": (x, y)}}'
        )
    return {**_shared_fields(scene), "name": _next_name(scene.name), "balls": balls}


def fields_at(
    scene: SceneContents, t: float, states: Sequence[FloatArray], gone: BoolArray
) -> dict[str, Any]:
    """Return the fields, except the name, of the scene at time t [s]; see `Result.at`.

    `states` are positions, velocities and angular velocities, (n, 3) each [m, m/s, rad/s].
    Raises `SceneError` if no ball is left.
    """
    positions, velocities, spins = states
    balls = _balls_at(scene, _above_cloth(scene, positions, velocities))
    for ball, velocity, spin in zip(balls, velocities.tolist(), spins.tolist(), strict=True):
        ball["velocity"] = tuple(velocity[: len(ball["position"])])
        if scene.physics.motion == "sliding":  # with "rolling", the velocity determines the spin
            ball["angular_velocity"] = tuple(spin)
    left = [ball for ball, is_gone in zip(balls, gone, strict=True) if not is_gone]
    if not left:
        raise refusal(
            f'scene "{scene.name}" must have a ball at {t:.9g} s, but none is left on the table. '
            "Give an earlier time"
        )
    fields = {**_shared_fields(scene), "balls": left}
    if scene.t_max is not None and t < scene.t_max:
        fields["t_max"] = scene.t_max - t
    return fields


def _above_cloth(scene: SceneContents, positions: FloatArray, velocities: FloatArray) -> FloatArray:
    """Return the positions of balls, (n, 3) [m], with each falling ball above the cloth.

    Just before a ball lands, its height rounds to its radius; the next larger double keeps it in
    the air.
    """
    positions, radii = positions.copy(), scene.radii
    fallen = velocities[:, 2] ** 2 / (2.0 * scene.physics.gravity)
    lands = (velocities[:, 2] < 0.0) & (positions[:, 2] <= radii)
    lands &= positions[:, 2] >= radii - position_rounding(radii, fallen)
    positions[lands, 2] = np.nextafter(radii[lands], np.inf)
    return positions


def _shared_fields(scene: SceneContents) -> dict[str, Any]:
    """Return the fields that a later scene takes from `scene`: physics, table and `t_max`."""
    return {"physics": scene.physics, "table": scene.table, "t_max": scene.t_max}


def _balls_at(scene: SceneContents, positions: FloatArray) -> list[dict[str, Any]]:
    """Return the fields of a scene's balls at rest at other positions, (n, 3) [m].

    If balls stay on the cloth, their height is omitted.
    """
    place = slice(3 if scene.physics.airborne else 2)
    found = []
    for ball, position in zip(scene.balls, positions.tolist(), strict=True):
        fields = {name: getattr(ball, name) for name in type(ball).model_fields}
        kept = {name: value for name, value in fields.items() if name not in _MOTION}
        found.append({**kept, "position": tuple(position[place])})
    return found


def gone_by_place(scene: SceneContents, positions: FloatArray) -> BoolArray:
    """Return which balls at rest are in a hole or off the table, (n,), for a result without events.

    `positions` is (n, 3) [m]. Only airborne balls can leave the table.
    """
    x, y = positions[:, 0], positions[:, 1]
    gone = np.zeros(len(x), dtype=np.bool_)
    table = scene.table
    if table is None:
        return gone
    rounding = position_rounding(x, y, np.array(table.length), np.array(table.width))
    for hole in table.holes:
        gone |= gap_to(hole, x, y) <= rounding
    if scene.physics.airborne:
        for side in table.sides:
            gone |= side.distance(x, y) <= rounding
        if not table.is_rectangle:
            gone |= ~is_inside(table.outline, x, y)
            for one in table.obstacles:
                if not isinstance(one, Hole | Disc):
                    gone |= gap_to(one, x, y) <= rounding
    return gone


def _next_name(name: str) -> str:
    """Return the name of the next scene: "break.2" after "break", "break.3" after "break.2"."""
    found = _NAME.fullmatch(name)
    assert found is not None  # every text matches
    ending = f".{int(found['number'] or 1) + 1}"
    return found["shot"][: _LONGEST_NAME - len(ending)] + ending
