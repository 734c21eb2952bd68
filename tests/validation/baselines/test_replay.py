"""An engine that gives other bits each time is found out, and none is played more than it needs."""

import gate
import pytest

from ghostball.model import EngineFailedError
from ghostball.validation.baselines import replay
from ghostball.validation.baselines.replay import not_deterministic, playing_again

RUN = gate.observed(gate.cut_shot())
SCENE = gate.cut_shot()


def asked(bits, again):
    return not_deterministic(RUN, bits, again, SCENE, "command")


def test_what_was_accepted_is_not_played_again():
    assert asked(RUN.bits, pytest.fail) is None


def test_other_bits_are_played_again_and_must_stay():
    assert asked("", lambda _: RUN.bits) is None
    change = asked("a" * 64, lambda _: "b" * 64)
    assert (change.change, change.failed) == ("not-deterministic", True)
    assert "it gave other bits" in change.summary
    assert "it failed: gone" in asked("", lambda _: "it failed: gone").summary


def test_a_shot_is_played_to_its_bits_or_to_why_there_are_none(monkeypatch):
    with playing_again("ghostball") as again:
        assert again(SCENE) == RUN.bits

        def fails(*_):
            raise EngineFailedError("ghostball", "gone")

        monkeypatch.setattr(replay, "run_engine", fails)
        assert again(SCENE).startswith("it failed: ")
