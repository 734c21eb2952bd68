"""A trial: who is to blame for an error, and how severe one is."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from ghostball.model import EngineFailedError, GhostballError, UnsupportedSceneError
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.stress.trial import CRASHED, NOT_FINITE, graded_severity, play


def raising(error):
    def run(*_, **__):
        raise error

    return run


def test_an_engine_is_to_blame_for_its_own_errors_and_for_what_it_hands_back():
    scene = find_scene("head-on")
    for simulate in (raising(GhostballError("no")), lambda *_, **__: "no result"):
        engine = SimpleNamespace(name="planted", simulate=simulate)
        with pytest.raises(EngineFailedError):
            play(engine, scene)
    engine.simulate = raising(UnsupportedSceneError("planted", ("no spin",)))
    with pytest.raises(UnsupportedSceneError):
        play(engine, scene)


@pytest.mark.parametrize(
    ("nearness", "broken", "severity"),
    [
        (0.5, False, 0.5),
        (3.0, False, 0.999),
        (float("nan"), False, 0.0),
        (-1.0, False, 0.0),
        (0.5, True, 1.0),
        (3.0, True, 3.0),
        (1e13, True, NOT_FINITE),
        (float("nan"), True, NOT_FINITE),
    ],
)
def test_severity_tells_how_far_beyond_and_never_says_crash(nearness, broken, severity):
    assert graded_severity(nearness, broken) == severity < CRASHED
