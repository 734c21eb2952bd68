"""The shots of a run are predicted once: again only where the scene or the code is another."""

from __future__ import annotations

import pytest

from ghostball.engine import Scene
from ghostball.validation.diagnose.predictability import load_predictability, predict
from ghostball.validation.diagnose.predictability.predict import predict_scenes
from ghostball.validation.results.frames import rows_of
from ghostball.validation.scenes.library import find_scene


@pytest.fixture
def measured(monkeypatch):
    """Names of the scenes that are measured, in order."""
    names: list[str] = []
    measure = predict.predictability_of

    def noting(scene):
        names.append(scene.name)
        return measure(scene)

    monkeypatch.setattr(predict, "predictability_of", noting)
    monkeypatch.setattr(predict, "code_hash", lambda: "this code")
    return names


def test_what_is_known_is_kept_to_the_byte(measured, tmp_path):
    scenes = [find_scene("push"), find_scene("chaos-a")]
    predict_scenes(scenes, tmp_path)
    stored = rows_of(tmp_path, "predictions")
    predict_scenes(scenes, tmp_path)
    assert measured == ["push", "chaos-a"]
    assert rows_of(tmp_path, "predictions") == stored


def test_an_interrupt_keeps_what_was_measured(measured, tmp_path):
    def interrupt(done, planned, name):
        if done == 1:
            raise KeyboardInterrupt

    scenes = [find_scene("push"), find_scene("stop")]
    with pytest.raises(KeyboardInterrupt):
        predict_scenes(scenes, tmp_path, progress=interrupt)
    assert [one.scene for one in predict_scenes(scenes, tmp_path)] == ["push", "stop"]
    assert measured == ["push", "stop"]


def test_another_scene_of_the_same_name_is_measured(measured, tmp_path):
    scene = find_scene("roll-distance")
    predict_scenes([scene], tmp_path)
    longer = Scene.model_validate({**scene.model_dump(by_alias=True), "t_max": 1.0})
    (known,) = predict_scenes([longer], tmp_path)
    assert measured == ["roll-distance", "roll-distance"]
    assert known.rest_time == 1.0
    assert load_predictability(tmp_path)["roll-distance"].rest_time == 1.0


def test_other_code_measures_again_and_so_does_who_asks_for_it(measured, monkeypatch, tmp_path):
    scenes = [find_scene("stop")]
    predict_scenes(scenes, tmp_path)
    predict_scenes(scenes, tmp_path, reuse=False)
    assert len(measured) == 2
    monkeypatch.setattr(predict, "code_hash", lambda: "other code")
    predict_scenes(scenes, tmp_path)
    assert len(measured) == 3


def test_code_that_cannot_be_told_neither_gives_nor_takes(measured, monkeypatch, tmp_path):
    scenes = [find_scene("stop")]
    predict_scenes(scenes, tmp_path)
    monkeypatch.setattr(predict, "code_hash", lambda: "")
    for _ in range(2):
        predict_scenes(scenes, tmp_path)
    assert len(measured) == 3


def test_what_our_engine_does_not_represent_is_passed_over(measured, tmp_path):
    # It has air drag on the cloth, and flight without air, not the two together.
    scene = find_scene("sliding-stun").model_dump(by_alias=True)
    scene["physics"] = {**scene["physics"], "airborne": True, "air_drag": 0.1}
    assert predict_scenes([Scene.model_validate(scene)], tmp_path) == []
    assert measured == []
