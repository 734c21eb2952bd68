"""The generator knows every field, and a scene before it is spoilt is in order."""

from hypothesis import given, settings

from engine import Ball, Physics, Scene, Table
from validation.stress.malformed import _CHOICES, NUMBERS
from validation.stress.plain_scenes import literal, well_formed, written


def test_every_field_of_a_number_is_spoilt():
    # Breaks where a new field joins a scene, and nothing tries it.
    others = {"preset", "airborne", *_CHOICES}
    assert set(Physics.model_fields) == set(NUMBERS["physics"]) | others
    vectors = {"id", "position", "velocity", "angular_velocity"}
    assert set(Ball.model_fields) == set(NUMBERS["balls"]) | vectors
    assert set(Table.model_fields) == {*NUMBERS["table"], "cushions"}


@settings(max_examples=50)
@given(well_formed())
def test_what_is_spoilt_was_in_order(data):
    text, _ = written(data)
    assert Scene.loads(text) == Scene(**data)


def test_the_line_of_a_field_is_its_own_else_that_of_the_part_around_it():
    scene = {"schema": 1, "name": "a", "physics": {"gravity": 1.0}, "balls": [{"id": "x"}]}
    text, line = written(scene, ("physics", "gravity"))
    assert text.splitlines()[line - 1] == "gravity = 1.0"
    text, line = written(scene, ("balls", 0, "position"))
    assert text.splitlines()[line - 1] == "[[balls]]"
    assert written(scene, ("table", "length"))[1] == 0


def test_literals_are_toml():
    assert literal({"a": [1, 2.5, "x", True]}) == '{a = [1, 2.5, "x", true]}'
