"""Messages of invalid scenes; each message is checked to be short and printable."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from shots import scene_of

from ghostball.model import Scene, SceneError

LONGEST_LINE = 700
"""Characters that a line of a refusal may have: an input is described in a few words."""


def refusal_of(read: Callable[[], object]) -> str:
    """Return the message with which an input is refused."""
    with pytest.raises(SceneError) as caught:
        read()
    message = str(caught.value)
    assert message
    for line in message.splitlines():
        assert len(line) <= LONGEST_LINE
        assert line.isprintable()
    return message


def refusal(*balls: dict[str, Any], **fields: Any) -> str:
    """Return the message with which a scene of these balls is refused."""
    return refusal_of(lambda: scene_of(*balls, **fields))


def loading(text: str) -> str:
    """Return the message with which a file, called shot.toml, is refused."""
    return refusal_of(lambda: Scene.loads(text, "shot.toml"))
