"""What all parts of a scene have in common: checked as they are made, frozen, refused in words."""

from __future__ import annotations

from typing import Any, Self

from pydantic import BaseModel, ConfigDict, ValidationError

from ghostball.model.errors import SceneError
from ghostball.model.scene.messages import describe


class Part(BaseModel):
    """What is checked as it is made, frozen, and refused with one sentence."""

    # A part that pydantic made without its checks is checked where it becomes part of a whole.
    model_config = ConfigDict(
        frozen=True, extra="forbid", populate_by_name=True, revalidate_instances="always"
    )

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
