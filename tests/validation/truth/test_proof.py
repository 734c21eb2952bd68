"""A proof for the suite: it is kept, it says why there is none, and that it takes long."""

import logging
import time

from ghostball.model import Ball, Physics, Scene
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.truth import proof as module
from ghostball.validation.truth.proof import proof_of, refused_features


def test_a_scene_is_proved_with_its_motion():
    proof, why = proof_of(find_scene("half-ball-cut"))
    assert (proof.proved, why) == (True, "")
    assert proof.segments is not None


def test_what_cannot_be_proved_is_named():
    cue = Ball(id="cue", position=(0.0, 0.0), velocity=(1.0, 0.0))
    other = Ball(id="object", position=(0.5, 0.01))
    physics = Physics(preset="pool", ball_impact="mathavan2014")
    scene = Scene(name="integrated", physics=physics, balls=[cue, other])
    proof, why = proof_of(scene)
    assert proof is None
    assert why == refused_features(scene) != ""


def test_only_a_proof_that_takes_long_is_announced(monkeypatch, caplog):
    monkeypatch.setattr(module, "PATIENCE", 0.01)
    monkeypatch.setattr(module, "certify", lambda scene, settings, motion: time.sleep(0.2))
    with caplog.at_level(logging.WARNING, "ghostball.validation"):
        proof_of(find_scene("stop"))
        assert 'proving scene "stop"' in caplog.text
        caplog.clear()
        monkeypatch.setattr(module, "certify", lambda scene, settings, motion: None)
        proof_of(find_scene("stop"))
        time.sleep(0.05)
    assert caplog.text == ""
