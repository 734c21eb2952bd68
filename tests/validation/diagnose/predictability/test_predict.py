"""The shots of a run are predicted once: again only where the scene or the code is another."""

from __future__ import annotations

import json

import pytest

from engine import Scene
from validation.diagnose.predictability import load_predictability, predict
from validation.diagnose.predictability.predict import predict_scenes
from validation.diagnose.predictability.prediction import SCHEMA
from validation.diagnose.predictability.prediction_file import PREDICTABILITY_FILE
from validation.results.files import ResultsError
from validation.scenes.library import find_scene
from validation.suite.unchanged import Code


@pytest.fixture
def measured(monkeypatch):
    """Names of the scenes that are measured, in order."""
    names: list[str] = []
    measure = predict.predictability_of

    def noting(scene):
        names.append(scene.name)
        return measure(scene)

    monkeypatch.setattr(predict, "predictability_of", noting)
    monkeypatch.setattr(Code, "now", staticmethod(lambda: Code("this code")))
    monkeypatch.setattr(Code, "holds", lambda _: True)
    return names


def test_what_is_known_is_kept_to_the_byte(measured, tmp_path):
    scenes = [find_scene("push"), find_scene("chaos-a")]
    predict_scenes(scenes, tmp_path)
    stored = (tmp_path / PREDICTABILITY_FILE).read_bytes()
    predict_scenes(scenes, tmp_path)
    assert measured == ["push", "chaos-a"]
    assert (tmp_path / PREDICTABILITY_FILE).read_bytes() == stored


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
    monkeypatch.setattr(Code, "now", staticmethod(lambda: Code("other code")))
    predict_scenes(scenes, tmp_path)
    assert len(measured) == 3


def test_code_that_cannot_be_told_neither_gives_nor_takes(measured, monkeypatch, tmp_path):
    scenes = [find_scene("stop")]
    predict_scenes(scenes, tmp_path)
    monkeypatch.setattr(Code, "now", staticmethod(lambda: Code("", "why")))
    monkeypatch.setattr(Code, "holds", lambda _: False)
    for _ in range(2):
        predict_scenes(scenes, tmp_path)
    assert len(measured) == 3


def test_a_file_of_schema_1_is_read_and_what_it_holds_is_measured_again(measured, tmp_path, caplog):
    # It had no hash of the code.
    scenes = [find_scene("stop")]
    (now,) = predict_scenes(scenes, tmp_path)
    path = tmp_path / PREDICTABILITY_FILE
    line = json.loads(path.read_text())
    assert line["schema"] == SCHEMA
    del line["code_hash"]
    path.write_text(json.dumps(line | {"schema": 1}) + "\n")
    then = load_predictability(tmp_path)["stop"]
    assert (then.schema, then.code_hash, then.rest_time) == (SCHEMA, "", now.rest_time)
    predict_scenes(scenes, tmp_path)
    assert len(measured) == 2
    assert caplog.text == ""


def test_a_file_of_a_newer_schema_is_said_to_be_of_another_version(measured, tmp_path):
    predict_scenes([find_scene("stop")], tmp_path)
    path = tmp_path / PREDICTABILITY_FILE
    line = json.loads(path.read_text()) | {"schema": SCHEMA + 1, "unheard_of": 1}
    path.write_text(json.dumps(line) + "\n")
    with pytest.raises(ResultsError, match="another version of ghostball wrote it"):
        load_predictability(tmp_path)


def test_a_damaged_file_is_replaced(measured, tmp_path, caplog):
    scenes = [find_scene("stop")]
    predict_scenes(scenes, tmp_path)
    path = tmp_path / PREDICTABILITY_FILE
    path.write_bytes(path.read_bytes()[:-5])
    predict_scenes(scenes, tmp_path)
    assert len(measured) == 2
    assert "cut short" in caplog.text
    assert list(load_predictability(tmp_path)) == ["stop"]


def test_what_our_engine_does_not_represent_is_passed_over(measured, tmp_path):
    # A table with air drag is none of its features.
    scene = find_scene("roll-distance").model_dump(by_alias=True)
    scene["physics"] = {**scene["physics"], "air_drag": 0.1}
    assert predict_scenes([Scene.model_validate(scene)], tmp_path) == []
    assert len(measured) == 1
