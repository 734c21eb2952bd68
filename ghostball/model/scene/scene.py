"""A scene: balls, table and physics of one shot, in SI units, validated once and frozen.

`Scene` is what every engine of the harness takes. It is checked here, at the boundary, and trusted
everywhere else. What a field may hold is in `scene.fields`, the rules between fields and parts are
in `scene.rules`, and reading and writing TOML is in `scene.toml`.
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
from ghostball.model.scene.from_arrays import add_strikes, fields_of_balls
from ghostball.model.scene.later import Change, EndedShot, fields_after
from ghostball.model.scene.messages import describe, refusal
from ghostball.model.scene.rules import check_scene
from ghostball.model.scene.starts import let_table_answer_strikes
from ghostball.model.scene.strike import Strike
from ghostball.model.views import view_of


class Scene(SceneContents):
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
        return cls.loads(toml.read(place), str(place))

    @classmethod
    def loads(cls, text: str, source: str = "<scene>") -> Scene:
        """Read a scene from TOML text; `source` is what errors call it."""
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
        """Make a scene of n balls from arrays: sooner than ball by ball, checked as well.

        Parameters
        ----------
        positions : (n, 2 or 3) float64 [m]
            Centres; a height that is left out is the radius: on the cloth.
        velocities : (n, 2 or 3) float64 [m/s]
            None: all balls rest.
        angular_velocities : (n, 3) float64 [rad/s]
            None: those of rolling without slip.
        name : str
        ids : sequence of n str
            None: "ball-0", "ball-1", ...
        radii, masses : (n,) float64 [m, kg], or one number for all
            None: the value of the table's preset, or the value of pool balls without a preset.
        strikes : dict of int to Strike
            By index of the ball, in place of `velocities` and `angular_velocities`. None: none.
        **fields
            `table`, `physics`, `t_max` and so on, as `Scene` takes them.

        Raises
        ------
        SceneError
            Where arrays don't go together, or a rule of scenes is broken.
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
        has no title and no tags. All values come from `result.scene`, because this is a class
        method.

        Parameters
        ----------
        result : Result
            Result of any engine, in which every ball is at rest.
        name : str, optional
            Name of the new scene; None adds the number of the shot, as "break.2" after "break".
        changes : dict of str to dict, optional
            New values for fields of balls, by ball id, such as
            ``{"cue": {"strike": Strike(speed=2.0, direction=0.5)}}``. A removed ball comes back on
            the table if its ``position`` is given.
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
        """Return the scene whose balls have velocities in place of strikes, which moves alike.

        Itself where none has a strike. For engines that read velocities alone.
        """
        if all(ball.strike is None for ball in self.balls):
            return self
        fields = {name: getattr(self, name) for name in type(self).model_fields}
        return Scene(**fields | {"balls": [ball.without_strike() for ball in self.balls]})

    def _repr_svg_(self) -> str | None:
        """Return what a notebook shows: the balls, and where those that move are going."""
        return view_of(self)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        let_table_answer_strikes(self)
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
    """Check a scene anew, with all its parts, unless it was made by its checks.

    Raises `SceneError` where a rule is broken.
    """
    if scene.is_checked:
        return
    made = "The scene was made without its checks (by a copy, or by `model_construct`)"
    try:
        checked = type(scene).model_validate(scene)
    except SceneError as error:
        raise SceneError(f"{error} {made}") from None
    if checked != scene:
        raise refusal(f"{made}, which would have changed it. Make it by Scene(...)")
    object.__setattr__(scene, "_checked", True)


def json_schema() -> str:
    """Return the JSON schema of scene files, so that editors complete and check them."""
    schema = Scene.model_json_schema(by_alias=True)
    schema["required"] = ["schema", *schema["required"]]
    return json.dumps({"$schema": "http://json-schema.org/draft-07/schema#"} | schema, indent=2)
