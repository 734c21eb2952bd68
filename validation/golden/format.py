"""The JSON format of golden shots; `golden.schema.json` is its schema."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import to_jsonable_python

from ghostball.model import GhostballError, Scene
from ghostball.model.text_files import read_text
from ghostball.validation.results.files import describe_validation_error

SCHEMA = 1
"""Version of the format."""

SCHEMA_FILE, SCENE_SCHEMA_FILE = SCHEMA_FILES = ("golden.schema.json", "scene.schema.json")
"""The schema of golden shots and that of scenes, in each folder of golden shots."""

Reference = Literal["closed form", "proof", "integration"]

Number = Annotated[float, Field(allow_inf_nan=False)]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)


class GoldenEvent(_Part):
    """An event, in the format of `ghostball run --format json`."""

    t: Number = Field(description="Time [s].")
    kind: str = Field(description='Kind of the event, such as "ball-ball".')
    a: int = Field(description="Index of the ball.")
    b: int | str | None = Field(
        description="Index of the second ball, or name of the cushion or pocket, or null."
    )


class Tolerance(_Part):
    """The tolerance of each number: error of the reference, and rounding in double precision."""

    events: tuple[Number, ...] = Field(description="Tolerance of the time of each event [s].")
    rest_positions: tuple[Number, ...] | None = Field(
        description="Tolerance of each ball's coordinates [m]; null if `rest_positions` is null."
    )


_PARTS = (GoldenEvent, Tolerance)


class GoldenShot(_Part):
    """A scene with its reference result, up to the time until which engines can be compared."""

    version: Literal[1] = Field(alias="schema", description="Version of this format.")
    reference: Reference = Field(
        description="Source of the rest positions: a closed form, a proof in interval arithmetic, "
        "or an integration with 40 digits. Event times are from the proof or the integration."
    )
    valid_until: Number | None = Field(
        description="Time until which events can be compared [s]; null: the whole shot."
    )
    scene: Scene = Field(description="The scene in plain numbers; velocities replace strokes.")
    strikes: tuple[dict[str, Any], ...] = Field(
        description="The strokes of a cue that gave balls their velocities; often empty."
    )
    events: tuple[GoldenEvent, ...] = Field(description="All events up to `valid_until`, by time.")
    rest_positions: tuple[tuple[Number, Number, Number], ...] | None = Field(
        description="Final centres [m], at rest or at `t_max`; null if `valid_until` is a number."
    )
    tolerance: Tolerance

    def to_values(self) -> dict[str, Any]:
        """Return the shot as values for JSON."""
        scene = json_values(self.scene)
        return self.model_dump(mode="json", by_alias=True, exclude={"scene"}) | {"scene": scene}


def golden_schema() -> str:
    """Return the JSON schema of golden shots, which refers to that of scenes."""
    schema = GoldenShot.model_json_schema(by_alias=True)
    schema["properties"]["scene"]["$ref"] = SCENE_SCHEMA_FILE
    schema["$defs"] = {one.__name__: schema["$defs"][one.__name__] for one in _PARTS}
    return json.dumps({"$schema": "http://json-schema.org/draft-07/schema#"} | schema, indent=2)


def read_golden(folder: Path) -> dict[str, GoldenShot]:
    """Read a folder of golden shots, by name.

    Raises `GhostballError` if the folder has none, or if a file isn't valid; the message names it.
    """
    paths = sorted(path for path in folder.glob("*.json") if path.name not in SCHEMA_FILES)
    if not paths:
        raise GhostballError(
            f"{folder} holds no golden shots. `ghostball scenes --golden {folder}` writes them"
        )
    return {path.stem: _read(path) for path in paths}


def _read(path: Path) -> GoldenShot:
    try:
        shot = GoldenShot.model_validate_json(read_text(path))
    except ValidationError as error:
        why = describe_validation_error(error)
    except (OSError, UnicodeDecodeError, GhostballError) as error:
        why = str(error)
    else:
        sizes = (len(shot.events), len(shot.tolerance.events))
        if sizes[0] == sizes[1]:
            return shot
        why = f"`tolerance.events` must have a number for each of {sizes[0]} events, got {sizes[1]}"
    raise GhostballError(f"{path} isn't a golden shot: {why}. Write the folder again")


def json_values(scene: Scene) -> dict[str, Any]:
    """Return a scene as values for JSON, with every default.

    Strikes are replaced by the resulting velocities. The angular velocity of a rolling ball, which
    a scene file may leave out, is included.
    """
    values = scene.without_strikes().model_dump(mode="json", by_alias=True)
    for ball, spin in zip(values["balls"], scene.angular_velocities.tolist(), strict=True):
        ball["angular_velocity"] = spin
    for name, part in (("physics", scene.physics), ("table", scene.table)):
        if part is not None:
            fields = type(part).model_fields.items()
            omitted = [key for key, one in fields if not one.exclude and key not in values[name]]
            values[name] |= to_jsonable_python({key: getattr(part, key) for key in omitted})
    return values
