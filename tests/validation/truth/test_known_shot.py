"""The best known motion of a scene: certified if possible, otherwise with the reason."""

import logging
import time

import numpy as np
import pytest
from shots import crowded_table
from toy_engines import roll

from ghostball.model import Ball, Physics, Scene, UnsupportedSceneError
from ghostball.validation import find_scene
from ghostball.validation.truth import certificates as module
from ghostball.validation.truth.certificates import certificate_of, refused_features
from ghostball.validation.truth.known_shot import known_shot


def test_certified_where_it_can_be():
    known = known_shot(find_scene("half-ball-cut"))
    assert known.kind == known.engine == "certified"
    assert known.why == ""
    np.testing.assert_array_equal(known.positions(None), known.rest_positions[:, :2])
    assert known.positions(0.0)[0].tolist() == [0.5, 0.606425]


def in_an_order(name):
    """Return a shipped scene with simultaneous impacts that act one after another."""
    scene = find_scene(name)
    physics = scene.physics.model_copy(update={"impacts": "sequential"})
    return scene.model_copy(update={"physics": physics})


@pytest.mark.parametrize(
    ("scene", "kind", "why"),
    [
        (in_an_order("corner-exact"), "closed form", "ambiguous"),
        (find_scene("mathavan-cut"), "our engine", "without a closed form"),
    ],
    ids=["ambiguous", "not certified"],
)
def test_without_a_proof_the_next_best_reference_is_used_with_the_reason(scene, kind, why):
    known = known_shot(scene)
    assert known.kind == kind
    assert known.engine == "ghostball"
    assert why in known.why


def test_what_nobody_represents_is_refused():
    with pytest.raises(UnsupportedSceneError, match="at most 53 obstacles"):
        known_shot(
            roll(physics=Physics(motion="sliding", cushion="mathavan2010"), table=crowded_table())
        )


def test_a_scene_is_proved_with_its_motion():
    proof, why = certificate_of(find_scene("half-ball-cut"))
    assert (proof.proved, why) == (True, "")
    assert proof.segments is not None


def test_what_cannot_be_proved_is_named():
    cue = Ball(id="cue", position=(0.0, 0.0), velocity=(1.0, 0.0))
    other = Ball(id="object", position=(0.5, 0.01))
    physics = Physics(preset="pool", ball_impact="mathavan2014")
    scene = Scene(name="integrated", physics=physics, balls=[cue, other])
    proof, why = certificate_of(scene)
    assert proof is None
    assert why == refused_features(scene) != ""


def test_only_a_proof_that_takes_long_is_announced(monkeypatch, caplog):
    monkeypatch.setattr(module, "MESSAGE_DELAY", 0.01)
    monkeypatch.setattr(module, "certify", lambda scene, settings, motion: time.sleep(0.2))
    with caplog.at_level(logging.WARNING, "ghostball.validation"):
        certificate_of(find_scene("stop"))
        assert 'certifying scene "stop"' in caplog.text
        caplog.clear()
        monkeypatch.setattr(module, "certify", lambda scene, settings, motion: None)
        certificate_of(find_scene("stop"))
        time.sleep(0.05)
    assert caplog.text == ""
