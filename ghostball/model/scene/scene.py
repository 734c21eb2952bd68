"""A scene: balls, table and physics of one shot, in SI units, validated once and frozen.

Every engine takes a `Scene`. A scene is validated here, when it is created, and trusted everywhere
else. The values that a field may have are defined in `scene.fields`, the rules between fields in
`scene.rules`; reading and writing TOML is in `scene.toml`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Self

from numpy.typing import ArrayLike
from pydantic import ValidationError, model_validator

from ghostball.model.errors import SceneError
from ghostball.model.scene import toml
from ghostball.model.scene.contents import SceneContents
from ghostball.model.scene.continuation import Change, EndedShot, fields_after
from ghostball.model.scene.from_arrays import add_strikes, fields_of_balls
from ghostball.model.scene.initial_states import apply_table_reaction
from ghostball.model.scene.messages import describe, refusal
from ghostball.model.scene.rules import check_scene
from ghostball.model.scene.strike import Strike
from ghostball.model.views import view_of


class Scene(SceneContents):
    """A shot: the input of every engine.

    Attributes
    ----------
    name : str
        Identifier, used in file names: lower case letters, digits, ".", "_", "-".
    title : str
        What the scene tests, in one line.
    tags : tuple of str
    balls : tuple of Ball
        At least one; results list balls in this order.
    table : Table or None
        None: an unbounded cloth.
    physics : Physics
    rack : Rack or None
        An argument only: the balls of the rack are added after those in `balls`. A finished scene
        has all balls in `balls`, and None here.
    t_max : float or None
        Time at which the simulation stops [s]; None: when all balls are at rest.
    """

    @classmethod
    def load(cls, path: str | Path) -> Scene:
        """Read a scene from a TOML file.

        Raises
        ------
        SceneError
            If the file can't be read, isn't TOML, or breaks a rule; the message names file, line,
            field, value and rule.
        """
        try:
            place = Path(path)
        except TypeError:
            raise refusal(
                f"`path` of a scene must be text or a Path, got {type(path).__name__}"
            ) from None
        return cls.loads(toml.read(place), str(place))

    @classmethod
    def loads(cls, text: str, source: str = "<scene>") -> Scene:
        """Read a scene from TOML text; error messages call the text `source`."""
        data = toml.parse(text, source)
        try:
            scene: Scene = cls.__pydantic_validator__.validate_python(data)
        except ValidationError as error:
            raise SceneError(describe(error, cls, source, text)) from None
        return scene

    @classmethod
    def from_arrays(
        cls,
        positions: ArrayLike,
        velocities: ArrayLike | None = None,
        angular_velocities: ArrayLike | None = None,
        *,
        name: str,
        ids: Sequence[str] | None = None,
        radii: ArrayLike | None = None,
        masses: ArrayLike | None = None,
        strikes: Mapping[int, Strike] | None = None,
        **fields: Any,
    ) -> Scene:
        """Make a scene of n balls from arrays: faster than from `Ball`s, with the same checks.

        Parameters
        ----------
        positions : (n, 2 or 3) float64 [m]
            Centres. Without z, the ball lies on the cloth.
        velocities : (n, 2 or 3) float64 [m/s]
            None: all balls are at rest.
        angular_velocities : (n, 3) float64 [rad/s]
            None: rolling without slip.
        name : str
        ids : sequence of n str
            None: "ball-0", "ball-1", ...
        radii, masses : (n,) float64 [m, kg], or one number for all
            None: the values of the presets of table and physics, or those of pool balls.
        strikes : dict of int to Strike
            By index of the ball, instead of `velocities` and `angular_velocities`; default: none.
        **fields
            `table`, `physics`, `t_max` and so on, as for `Scene`.

        Raises
        ------
        SceneError
            If the shapes of the arrays don't match, or the scene is invalid.
        """
        columns = {"position": positions, "velocity": velocities, "radius": radii, "mass": masses}
        columns["angular_velocity"] = angular_velocities
        balls = fields_of_balls(ids, columns)
        add_strikes(balls, strikes or {})
        return cls(name=name, balls=balls, **fields)

    @classmethod
    def after(
        cls,
        result: EndedShot,
        *,
        name: str | None = None,
        changes: Mapping[str, Change] | None = None,
        **fields: Any,
    ) -> Scene:
        """Make the scene of the next shot: the balls rest where a shot left them.

        Balls that were pocketed or left the table are removed. The other balls keep their id,
        radius, mass and frictions; the table, the physics and `t_max` stay the same. The new scene
        has no title and no tags. All values come from `result.scene`, even if the method is called
        on another scene.

        Parameters
        ----------
        result : Result
            Result of any engine, in which every ball is at rest.
        name : str, optional
            Name of the new scene; None adds the number of the shot, as "break.2" after "break".
        changes : dict of str to dict, optional
            New values for fields of balls, by ball id, such as ``{"cue": {"strike":
            Strike(speed=2.0, direction=0.5)}}``. A removed ball comes back on the table if its
            ``position`` is given.
        **fields
            Other fields of the new scene, such as `title`.

        Returns
        -------
        Scene

        Raises
        ------
        SceneError
            If a ball isn't at rest, if no ball is left, if `changes` names an unknown ball, or if
            the state breaks a rule of scenes. If an engine left balls overlapping, the error names
            the balls and the overlap [m]; no ball is moved.
        """
        after = fields_after(result, {} if changes is None else changes)
        given = {} if name is None else {"name": name}
        return made_after(lambda: cls(**{**after, **given, **fields}), result.engine)

    def save(self, path: str | Path) -> None:
        """Write the scene as TOML; `load` reads back an equal scene, to the last bit."""
        toml.write(toml.dumps(self), Path(path))

    def without_strikes(self) -> Scene:
        """Return an equivalent scene whose balls have velocities instead of strikes.

        The result is the scene itself if no ball has a strike. This is for engines that read only
        velocities.
        """
        if all(ball.strike is None for ball in self.balls):
            return self
        fields = {name: getattr(self, name) for name in type(self).model_fields}
        return Scene(**fields | {"balls": [ball.without_strike() for ball in self.balls]})

    def _repr_svg_(self) -> str | None:
        """Return the picture for a notebook: the balls, and the directions of moving balls."""
        return view_of(self)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        self._rack_up()
        apply_table_reaction(self)
        check_scene(self)
        return self


def made_after(make: Callable[[], Scene], engine: str) -> Scene:
    """Return the scene that `make` builds from the final state of an engine.

    Raises `SceneError`, which names the engine, if the state breaks a rule of scenes.
    """
    try:
        return make()
    except SceneError as error:
        raise SceneError(f"after a shot on engine `{engine}`: {error}") from None


def check_whole(scene: Scene) -> None:
    """Check a scene and all its parts again, unless validation created the scene.

    Raises `SceneError` if a rule is broken.
    """
    if scene.is_checked:
        return
    made = "The scene was created without validation (by a copy, or by `model_construct`)"
    try:
        checked = type(scene).model_validate(scene)
    except SceneError as error:
        raise SceneError(f"{error} {made}") from None
    if checked != scene:
        raise refusal(f"{made}, which would have changed it. Create it with Scene(...)")
    object.__setattr__(scene, "_checked", True)


def json_schema() -> str:
    """Return the JSON schema of scene files, with which editors complete and check them."""
    schema = Scene.model_json_schema(by_alias=True)
    schema["required"] = ["schema", *schema["required"]]
    return json.dumps({"$schema": "http://json-schema.org/draft-07/schema#"} | schema, indent=2)
