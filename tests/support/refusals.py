"""What is said where a scene is refused."""

from __future__ import annotations

from typing import Any

import pytest
from shots import scene_of

from engine import Scene, SceneError


def refusal(*balls: dict[str, Any], **fields: Any) -> str:
    """Return the message with which a scene of these balls is refused."""
    with pytest.raises(SceneError) as caught:
        scene_of(*balls, **fields)
    return str(caught.value)


def loading(text: str) -> str:
    """Return the message with which a file, called shot.toml, is refused."""
    with pytest.raises(SceneError) as caught:
        Scene.loads(text, "shot.toml")
    return str(caught.value)
