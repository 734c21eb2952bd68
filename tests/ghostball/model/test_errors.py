"""Errors say who failed and why, and come back whole from another process."""

from __future__ import annotations

import pickle

import pytest

from ghostball.model import EngineFailedError, GhostballError, SceneError, UnsupportedSceneError


@pytest.mark.parametrize(
    "error",
    [
        UnsupportedSceneError("toy", ("no flight", "no spin")),
        EngineFailedError("toy", "it raised ValueError", "line 3"),
        SceneError("`mass` must be positive"),
    ],
)
def test_an_error_survives_pickling(error):
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), str(again), vars(again)) == (type(error), str(error), vars(error))
    assert isinstance(again, GhostballError)


def test_only_what_our_own_engine_raised_is_our_bug():
    assert EngineFailedError("ghostball", "it raised", "line 3").is_our_bug
    assert not EngineFailedError("ghostball", "it hung").is_our_bug
    assert not EngineFailedError("toy", "it raised", "line 3").is_our_bug


def test_what_no_file_takes_is_written_as_python_writes_it():
    failed = EngineFailedError("toy", "ValueError: \udcff", "line \ud800")
    refused = UnsupportedSceneError("toy", ("no \udcff", "é 🎱"))
    assert (failed.reason, failed.trace) == (r"ValueError: \udcff", r"line \ud800")
    assert refused.features == (r"no \udcff", "é 🎱")
    for one in (failed, refused):
        str(one).encode()
