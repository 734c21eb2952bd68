"""Types of the fields of stored records: each field is validated when it is read, like input.

A results folder may come from anyone, for example as an artifact of a CI run.
"""

from __future__ import annotations

import json
from functools import lru_cache
from typing import Annotated, Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, BaseModel, PlainSerializer, PlainValidator, TypeAdapter

from ghostball.model import Scene, SceneError


def _array_from_json(value: Any) -> NDArray[np.float64]:
    try:
        return np.array(value, dtype=np.float64)  # null stands for a number that isn't finite
    except (TypeError, ValueError, OverflowError):
        raise ValueError("must be numbers in rows of one length") from None


def _array_to_json(value: NDArray[np.float64]) -> Any:
    # A diverged engine returns nan or infinity, which JSON can't represent.
    plain = value.astype(object)
    plain[~np.isfinite(value)] = None
    return plain.tolist()


def check_shape(name: str, array: NDArray[np.float64] | None, shape: tuple[int, ...]) -> None:
    """Check that a stored array, if it exists, has the right shape."""
    if array is not None and array.shape != shape:
        raise ValueError(f"`{name}` must have the shape {shape}, got {array.shape}")


StoredArray = Annotated[
    NDArray[np.float64],
    PlainValidator(_array_from_json),
    PlainSerializer(_array_to_json, when_used="json"),
]


def _as_scene(definition: dict[str, Any]) -> dict[str, Any]:
    if refused := _refused(json.dumps(definition)):
        raise ValueError(refused)
    return definition


@lru_cache(maxsize=256)  # all cases of a scene have the same definition
def _refused(definition: str) -> str:
    try:
        Scene.model_validate_json(definition)
    except SceneError as error:
        return f"must be a scene: {error}"
    return ""


Definition = Annotated[dict[str, Any], AfterValidator(_as_scene)]
"""A whole scene as plain values."""


class GitState(BaseModel):
    """The code revision of a run."""

    revision: str
    dirty: bool


class Environment(BaseModel, extra="allow"):
    """The fields of a run's environment that are read; other fields are only displayed."""

    date: str = ""
    command: list[str] = []
    cpu: str = ""
    cores: int | None = None
    os: str = ""
    python: str = ""
    versions: dict[str, str | None] = {}
    git: GitState | None = None


_ENVIRONMENT: Final = TypeAdapter(Environment)


def _as_environment(values: dict[str, Any]) -> dict[str, Any]:
    _ENVIRONMENT.validate_python(values)
    return values


EnvironmentValues = Annotated[dict[str, Any], AfterValidator(_as_environment)]
"""A field of a record: the dict from `describe_environment`, or a part of it."""
