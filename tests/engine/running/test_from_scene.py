"""A scene as arrays: what has no room in them is refused."""

from __future__ import annotations

import pytest
from more_obstacles import played_among
from shots import ball, scene_of

from ghostball.engine.core import state as st
from ghostball.model import Status, UnsupportedSceneError


def test_more_obstacles_than_bits_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Breaks where one is let through: a contact step would hold balls off another one."""
    disc = (st.DISC, 50.0, 50.0, 0.0, 0.0, 0.01, 0.0, 4)
    scene = scene_of(ball((0.0, 0.0), (1.0, 0.0)), rolling_friction=0.1)
    assert played_among(monkeypatch, scene, *[disc] * st.MOST_OBSTACLES).status is Status.REST
    scene = scene.model_copy()
    with pytest.raises(UnsupportedSceneError, match=r"at most 53 obstacles on the .* got 54"):
        played_among(monkeypatch, scene, *[disc] * (st.MOST_OBSTACLES + 1))
