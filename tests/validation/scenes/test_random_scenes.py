"""The generator of random scenes has options for every feature and produces every pair of them."""

import hashlib
import itertools
import subprocess
import sys
from collections import Counter

import pytest
from random_layouts import FEATURE_OPTIONS, has, options_in, touching_rails

from ghostball.model import Physics
from ghostball.model.features import Feature, scene_features
from ghostball.validation.scenes.random_scenes import ASPECTS, PAIRS, options_of, random_scene


def test_every_feature_has_its_options():
    assert set(FEATURE_OPTIONS) == set(Feature), "a feature without an entry in FEATURE_OPTIONS"
    for aspect, option in itertools.chain(*FEATURE_OPTIONS.values()):
        assert option in ASPECTS[aspect]


def test_a_scene_has_the_features_of_its_options_and_no_others(few):
    for scene in few:
        expected = tuple(one for one in Feature if has(one, options_in(scene)))
        assert scene_features(scene) == expected, scene.name


def test_every_pair_of_options_that_can_be_together_comes_round():
    drawn = [options_of(number).items() for number in range(len(PAIRS))]
    found = Counter(itertools.chain(*(itertools.combinations(one, 2) for one in drawn)))
    assert not [pair for pair in PAIRS if pair not in found]
    assert not set(found) - set(PAIRS)


def test_a_few_hundred_have_every_pair_of_features_that_can_be_together(few):
    found = Counter(
        itertools.chain(*(itertools.combinations(scene_features(scene), 2) for scene in few))
    )
    pairs = {frozenset(pair) for pair in PAIRS}
    for one, other in itertools.combinations(Feature, 2):
        together = any(
            frozenset(both) in pairs or both[0] == both[1]
            for both in itertools.product(FEATURE_OPTIONS[one], FEATURE_OPTIONS[other])
        )
        assert (found[one, other] > 0) == together, (one, other)


def test_a_scene_is_its_number_in_another_process_too(few):
    program = (
        "from ghostball.validation.scenes.random_scenes import random_scene;"
        'print([random_scene(number, count="few") for number in range(40)])'
    )
    said = subprocess.run(
        [sys.executable, "-c", program], check=True, capture_output=True, text=True
    )
    assert said.stdout.strip() == str(few[:40])
    assert len({scene.model_dump_json() for scene in few}) == len(few)


def test_the_presets_are_those_of_physics():
    assert list(ASPECTS["preset"]) == list(Physics.PRESETS)


def test_what_is_asked_for_is_there():
    for number in range(40):
        scene = random_scene(number, air="yes", layout="corner", along_rail="yes")
        assert scene.physics.air_drag > 0.0
        assert touching_rails(scene).any()
    with pytest.raises(ValueError, match="no scene has all of"):
        options_of(0, motion="rolling", flight="jump")
    with pytest.raises(KeyError):
        options_of(0, air="thin")


def test_what_flies_in_air_is_there_where_both_are_asked_for_alone():
    for number in range(40):
        scene = random_scene(number, air="yes", flight=("low", "jump", "drop", "on-top"))
        assert scene.physics.airborne
        assert scene.physics.air_drag > 0.0
        for having in ({}, {"air": "yes"}, {"flight": "jump"}):
            other = random_scene(number, **having).physics
            assert not (other.airborne and other.air_drag > 0.0)


def test_a_number_of_one_of_several_options_has_one_of_them():
    racks = ("rack", "loose-rack")
    drawn = [random_scene(n, layout=racks, table=("pool", "small")) for n in range(40)]
    assert {options_in(scene)["layout"] for scene in drawn} == set(racks)
    assert {options_in(scene)["table"] for scene in drawn} == {"pool", "small"}


def test_scenes_of_numbers_are_those_that_findings_name():
    """Fails if a draw is changed, added or removed: then each number gives a different scene."""
    digest = hashlib.sha256()
    for number in range(0, 20_000, 50):
        digest.update(random_scene(number).model_dump_json().encode())
    assert digest.hexdigest()[:16] == "f4e747634ce08f69"


def test_every_scene_has_a_ball_that_moves(few):
    assert all(any(ball.speed > 0.0 for ball in scene.balls) for scene in few)
