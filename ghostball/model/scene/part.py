"""What all parts of a scene have in common: checked as they are made, frozen, refused in words."""

from __future__ import annotations

from typing import Any, Self

from pydantic import BaseModel, ConfigDict, GetCoreSchemaHandler, ValidationError
from pydantic_core import CoreSchema, core_schema

from ghostball.model.errors import SceneError
from ghostball.model.scene.messages import describe


class Part(BaseModel):
    """What is checked as it is made, frozen, and refused with one sentence."""

    # Whether it was made by its checks. No field, nor a private attribute: pydantic would copy
    # these to a part with other fields.
    __slots__ = ("_checked",)

    # A part that pydantic made without its checks is checked where it becomes part of a whole.
    # Checks are built when they are first needed: who imports the engine may need none.
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
        # What files of schemas name a part by moves outwards, from the model to what is around it.
        inner = {**handler.resolve_ref_schema(handler(source))}
        name = inner.pop("ref")
        return core_schema.no_info_wrap_validator_function(cls._once_checked, inner, ref=name)

    @classmethod
    def _once_checked(cls, value: Any, check: core_schema.ValidatorFunctionWrapHandler) -> Self:
        """Return a part as it is where it was checked; else what its checks make of a value."""
        if type(value) is cls and value.is_checked:
            return value
        made: Self = check(value)
        object.__setattr__(made, "_checked", True)
        return made

    @property
    def is_checked(self) -> bool:
        """Whether it was made by its checks.

        `model_copy`, `model_construct`, `copy` and `pickle` make parts past them.
        """
        return getattr(self, "_checked", False)

    def __init__(self, /, **data: Any) -> None:
        try:
            super().__init__(**data)
        except ValidationError as error:
            raise SceneError(describe(error, type(self))) from None

    @classmethod
    def model_validate(cls, obj: Any, **options: Any) -> Self:
        """Make one of plain values, such as those of a JSON object.

        Raises `SceneError` where a rule is broken.
        """
        try:
            return super().model_validate(obj, **options)
        except ValidationError as error:
            raise SceneError(describe(error, cls)) from None

    @classmethod
    def model_validate_json(cls, json_data: str | bytes | bytearray, **options: Any) -> Self:
        """Make one of JSON text, such as `model_dump_json` writes.

        Raises `SceneError` where it is no JSON, or a rule is broken.
        """
        try:
            return super().model_validate_json(json_data, **options)
        except ValidationError as error:
            raise SceneError(describe(error, cls)) from None

    # pydantic would otherwise run this for nested models too, and lose where in the scene they are.
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]
