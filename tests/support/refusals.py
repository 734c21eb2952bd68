"""Messages of invalid scenes; each message is checked to be short and printable."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from shots import scene_of

from ghostball.model import Scene, SceneError

LONGEST_LINE = 700
"""Largest length of a line of an error message, which describes an input in a few words."""


def refusal_of(read: Callable[[], object]) -> str:
    """Return the error message for an invalid input."""
    with pytest.raises(SceneError) as caught:
        read()
    message = str(caught.value)
    assert message
    for line in message.splitlines():
        assert len(line) <= LONGEST_LINE
        assert line.isprintable()
    return message


def refusal(*balls: dict[str, Any], **fields: Any) -> str:
    """Return the error message for a scene with these balls."""
    return refusal_of(lambda: scene_of(*balls, **fields))


def loading(text: str) -> str:
    """Return the error message for a scene file with this text."""
    return refusal_of(lambda: Scene.loads(text, "shot.toml"))
