"""The base class of all parts of a scene: validated on construction, frozen."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, GetCoreSchemaHandler, ValidationError
from pydantic_core import CoreSchema, core_schema

from ghostball.model.errors import SceneError
from ghostball.model.scene.messages import describe


def with_preset(data: Any, presets: Mapping[str, Mapping[str, Any]], usual: str) -> Any:
    """Return the given fields of a part, and those of its preset that aren't given.

    `usual` is the preset if none is given. Data that isn't a dict is rejected later.
    """
    if not isinstance(data, dict):
        return data
    preset = data.get("preset", usual)
    return {**(presets.get(preset, {}) if isinstance(preset, str) else {}), **data}


class ScenePart(BaseModel):
    """Base class of a part of a scene: validated on construction, and frozen.

    An invalid part is rejected with a message of one line for each mistake.
    """

    # Whether validation created the part. A slot, because pydantic would copy a field or a private
    # attribute to a part with changed fields.
    __slots__ = ("_checked",)

    # A part that pydantic created without validation is validated when it becomes part of a scene.
    # Validators are built when they are first needed, because importing the engine may need none.
    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        populate_by_name=True,
        revalidate_instances="always",
        defer_build=True,
    )

    @classmethod
    def __get_pydantic_core_schema__(
        cls, source: Any, handler: GetCoreSchemaHandler, /
    ) -> CoreSchema:
        # The name in JSON schema files moves from the model schema to the schema that wraps it.
        inner = {**handler.resolve_ref_schema(handler(source))}
        name = inner.pop("ref")
        return core_schema.no_info_wrap_validator_function(cls._once_checked, inner, ref=name)

    @classmethod
    def _once_checked(cls, value: Any, check: core_schema.ValidatorFunctionWrapHandler) -> Self:
        """Return a part unchanged if it was validated before; otherwise validate the value."""
        if type(value) is cls and value.is_checked:
            return value
        made: Self = check(value)
        object.__setattr__(made, "_checked", True)
        return made

    @property
    def is_checked(self) -> bool:
        """Whether validation created the part.

        `model_copy`, `model_construct`, `copy` and `pickle` create parts without validation.
        """
        return getattr(self, "_checked", False)

    def __init__(self, /, **data: Any) -> None:
        try:
            super().__init__(**data)
        except ValidationError as error:
            raise SceneError(describe(error, type(self))) from None

    @classmethod
    def model_validate(cls, obj: Any, **options: Any) -> Self:
        """Create a part from plain values, such as those of a JSON object.

        Raises `SceneError` if a rule is broken.
        """
        try:
            return super().model_validate(obj, **options)
        except ValidationError as error:
            raise SceneError(describe(error, cls)) from None

    @classmethod
    def model_validate_json(cls, json_data: str | bytes | bytearray, **options: Any) -> Self:
        """Create a part from JSON text, such as the output of `model_dump_json`.

        Raises `SceneError` if the text isn't JSON or breaks a rule.
        """
        try:
            return super().model_validate_json(json_data, **options)
        except ValidationError as error:
            raise SceneError(describe(error, cls)) from None

    # Otherwise pydantic would call `__init__` for nested models too, and lose their location.
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]
