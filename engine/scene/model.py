"""A scene: balls, table and physics of one shot, in SI units, validated once and frozen.

`Scene` is what every engine of the harness takes. It is checked here, at the boundary, and trusted
everywhere else. What a field may hold is in `scene.fields`, the rules between fields and parts are
in `scene.rules`, and reading and writing TOML is in `scene.toml`.
"""

from __future__ import annotations

import json
import weakref
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, model_validator

from ghostball.engine.core.tolerances import EPS
from ghostball.engine.errors import SceneError
from ghostball.engine.scene import toml
from ghostball.engine.scene.fields import Positive, SceneName, Text, whole_number
from ghostball.engine.scene.messages import refusal
from ghostball.engine.scene.parts import Ball, Part, Physics, Table, rolling_angular_velocity
from ghostball.engine.scene.picture import picture
from ghostball.engine.scene.rules import check_scene

ROLLING_ULPS = 4.0
"""Slip of a ball that counts as rolling, in units of EPS times its speed; see `Scene.rolls`."""


class Scene(Part):
    """A shot: what every engine simulates.

    Attributes
    ----------
    name : str
        Identifier, used in file names: lower case letters, digits, ".", "_", "-".
    title : str
        What the scene probes, in one line.
    tags : tuple of str
    balls : tuple of Ball
        At least one; results list balls in this order.
    table : Table or None
        None is an unbounded cloth.
    physics : Physics
    t_max : float or None
        Where to stop [s]; None is "until every ball rests".
    """

    schema_version: Annotated[Literal[1], BeforeValidator(whole_number)] = Field(
        default=1, alias="schema"
    )
    name: SceneName
    title: Text = ""
    tags: tuple[Text, ...] = ()
    t_max: Positive | None = None
    physics: Physics = Field(default_factory=Physics)
    table: Table | None = None
    balls: Annotated[tuple[Ball, ...], Field(min_length=1)]

    @classmethod
    def load(cls, path: str | Path) -> Scene:
        """Read a scene from a TOML file.

        Raises
        ------
        SceneError
            Where the file can't be read, isn't TOML, or breaks a rule; the message names file,
            line, field, value and rule.
        """
        try:
            place = Path(path)
        except TypeError:
            raise refusal(
                f"`path` of a scene must be text or a Path, got {type(path).__name__}"
            ) from None
        return toml.load(place, cls)

    @classmethod
    def loads(cls, text: str, source: str = "<scene>") -> Scene:
        """Read a scene from TOML text; `source` is what errors call it."""
        return toml.loads(text, source, cls)

    def save(self, path: str | Path) -> None:
        """Write the scene as TOML; `load` reads back an equal scene, to the last bit."""
        toml.save(self, Path(path))

    def _repr_svg_(self) -> str:
        """Return what a notebook shows: the balls, and where those that move are going."""
        return picture(self)

    @property
    def positions(self) -> NDArray[np.float64]:
        """Centres at the start, (n, 3) float64 [m]; a fresh array."""
        return np.array([ball.position for ball in self.balls], dtype=np.float64)

    @property
    def velocities(self) -> NDArray[np.float64]:
        """Velocities at the start, (n, 3) float64 [m/s]; a fresh array."""
        return np.array([ball.velocity for ball in self.balls], dtype=np.float64)

    @property
    def angular_velocities(self) -> NDArray[np.float64]:
        """Angular velocities at the start, (n, 3) float64 [rad/s]; a fresh array."""
        rolling = rolling_angular_velocity(self.velocities, self.radii)
        for i, ball in enumerate(self.balls):
            if ball.angular_velocity is not None:
                rolling[i] = ball.angular_velocity
        return rolling

    @property
    def radii(self) -> NDArray[np.float64]:
        """Radii, (n,) float64 [m]; a fresh array."""
        return np.array([ball.radius for ball in self.balls], dtype=np.float64)

    @property
    def masses(self) -> NDArray[np.float64]:
        """Masses, (n,) float64 [kg]; a fresh array."""
        return np.array([ball.mass for ball in self.balls], dtype=np.float64)

    @property
    def rolling_frictions(self) -> NDArray[np.float64]:
        """Coefficients of rolling resistance, (n,) float64 [1]; a fresh array."""
        shared = self.physics.rolling_friction
        return _own_or_shared((ball.rolling_friction for ball in self.balls), shared)

    @property
    def sliding_frictions(self) -> NDArray[np.float64]:
        """Coefficients of sliding friction, ball on cloth, (n,) float64 [1]; a fresh array."""
        shared = self.physics.sliding_friction
        return _own_or_shared((ball.sliding_friction for ball in self.balls), shared)

    @property
    def spinning_friction_rates(self) -> NDArray[np.float64]:
        """Decelerations of vertical spin, (n,) float64 [rad/s^2]; a fresh array."""
        shared = self.physics.spinning_friction_rate
        return _own_or_shared((ball.spinning_friction_rate for ball in self.balls), shared)

    @property
    def rolls(self) -> NDArray[np.bool_]:
        """Whether each ball starts rolling without slip, or at rest, (n,) bool; a fresh array.

        Notes
        -----
        A ball whose angular velocity isn't given rolls; so does every ball where `motion` is
        "rolling". Otherwise the slip at its lowest point decides, (vx - R wy, vy + R wx): it must
        be at most 4 EPS times the larger of |v| and R |(wx, wy)|, which leaves room for the
        rounding of a v / R that somebody computed. Spin about the vertical doesn't matter, nor
        does height: a ball in the air that would roll on the cloth counts as rolling.
        """
        v, w, radii = self.velocities, self.angular_velocities, self.radii
        slip = np.hypot(v[:, 0] - radii * w[:, 1], v[:, 1] + radii * w[:, 0])
        speed = np.maximum(np.hypot(v[:, 0], v[:, 1]), radii * np.hypot(w[:, 0], w[:, 1]))
        given = np.array([ball.angular_velocity is not None for ball in self.balls])
        tied = self.physics.motion == "rolling"
        return tied | ~given | (slip <= ROLLING_ULPS * EPS * speed)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        check_scene(self, rolling_angular_velocity(self.velocities, self.radii))
        _note_checked(self)
        return self


_CHECKED: dict[int, weakref.ref[Scene]] = {}
"""Scenes that are known to keep the rules. By identity, since pydantic copies all else: a field, or
a private one, that said so would say so of a copy with other fields, too."""


def _note_checked(scene: Scene) -> None:
    key = id(scene)
    _CHECKED[key] = weakref.ref(scene, lambda _: _CHECKED.pop(key, None))


def check_whole(scene: Scene) -> None:
    """Check a scene anew, with all its parts, unless it was made by its checks.

    `model_copy`, `model_construct`, `copy` and `pickle` make scenes past them.

    Raises
    ------
    SceneError
        Where a rule is broken.
    """
    kept = _CHECKED.get(id(scene))
    if kept is not None and kept() is scene:
        return
    made = "The scene was made without its checks (by a copy, or by `model_construct`)"
    try:
        checked = type(scene).model_validate(scene)
    except SceneError as error:
        raise SceneError(f"{error} {made}") from None
    if checked != scene:
        raise refusal(f"{made}, which would have changed it. Make it by Scene(...)")
    _note_checked(scene)


def _own_or_shared(own: Iterable[float | None], shared: float) -> NDArray[np.float64]:
    return np.array([shared if value is None else value for value in own], dtype=np.float64)


def json_schema() -> str:
    """Return the JSON schema of scene files, so that editors complete and check them."""
    schema = Scene.model_json_schema(by_alias=True)
    schema["required"] = ["schema", *schema["required"]]
    return json.dumps({"$schema": "http://json-schema.org/draft-07/schema#"} | schema, indent=2)
