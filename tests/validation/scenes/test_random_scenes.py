"""The generator of random scenes: it knows every feature, and brings every pair together."""

import hashlib
import itertools
import math
import subprocess
import sys
from collections import Counter

import numpy as np
import pytest

from ghostball.model import Physics
from ghostball.model.features import Feature, scene_features
from ghostball.validation.scenes.random_parts import reach
from ghostball.validation.scenes.random_scenes import (
    ASPECTS,
    OF_FEATURES,
    PAIRS,
    options_of,
    random_scene,
)

FEW = range(200)
"""What `make test` plays, each with a few balls; more of them take most of the time."""


def has(feature, options):
    return any(options[aspect] == option for aspect, option in OF_FEATURES[feature])


@pytest.fixture(scope="module")
def few():
    return [random_scene(number, count="few") for number in FEW]


def options_in(scene):
    return dict(tag.split("=") for tag in scene.tags)


def test_every_feature_has_its_options():
    assert set(OF_FEATURES) == set(Feature), "a feature without an entry in OF_FEATURES"
    for aspect, option in itertools.chain(*OF_FEATURES.values()):
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
            for both in itertools.product(OF_FEATURES[one], OF_FEATURES[other])
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


@pytest.mark.parametrize("preset", ["carom", "snooker"])
def test_a_preset_that_is_asked_for_brings_no_features_of_its_own(preset):
    for number in FEW:
        scene = random_scene(number, preset=preset, count="few")
        expected = tuple(one for one in Feature if has(one, options_in(scene)))
        assert scene_features(scene) == expected, scene.name
        assert scene.physics.preset == preset


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


def test_gaps_of_loose_racks_are_of_any_size():
    gaps = []
    for number in range(100):
        scene = random_scene(number, layout="loose-rack", radii="equal", flight="no", count="many")
        pairs = itertools.combinations(scene.balls, 2)
        gaps.append(min(math.dist(a.position, b.position) - a.radius - b.radius for a, b in pairs))
    assert sum(gap < 1e-6 for gap in gaps) > 20
    assert sum(gap > 1e-4 for gap in gaps) > 20
    assert min(gaps) > 1e-10


def test_scenes_of_numbers_are_those_that_findings_name():
    """Breaks where a draw is changed, added or left out: then no number is its scene any more."""
    digest = hashlib.sha256()
    for number in range(0, 20_000, 50):
        digest.update(random_scene(number).model_dump_json().encode())
    assert digest.hexdigest()[:16] == "f4e747634ce08f69"


def touching_rails(scene):
    """Return which ball touches which cushion, (n, 4)."""
    touches = np.zeros((len(scene.balls), 4), dtype=bool)
    height, flies = scene.physics.cushion_height, scene.physics.airborne
    for i, ball in enumerate(scene.balls):
        edge = reach({"radius": ball.radius}, {"airborne": flies, "cushion_height": height})
        for side in () if scene.table is None else scene.table.sides:
            gap = side.distance(*ball.position[:2]) - edge
            touches[i, side.cushion] = abs(gap) < 1e-14 and ball.position[2] == ball.radius
    return touches


def touching_balls(scene):
    """Return how many pairs of balls touch."""
    return sum(
        abs(math.dist(one.position, other.position) - one.radius - other.radius) < 1e-13
        or (
            not scene.physics.airborne
            and abs(math.dist(one.position[:2], other.position[:2]) - one.radius - other.radius)
            < 1e-13
        )
        for one, other in itertools.combinations(scene.balls, 2)
    )


def test_balls_lie_as_their_options_say(few):
    """Nearly always: where there is no room they lie elsewhere."""
    found = Counter()
    for scene in few:
        options = options_in(scene)
        rails, pairs = touching_rails(scene), touching_balls(scene)
        along = [
            ball
            for ball, touches in zip(scene.balls, rails, strict=True)
            if (touches[:2].any() and ball.velocity[0] == 0.0 != ball.velocity[1])
            or (touches[2:].any() and ball.velocity[1] == 0.0 != ball.velocity[0])
        ]
        facts = {
            ("layout", "touching"): pairs > 0,
            ("layout", "rack"): pairs > 2,
            ("layout", "rack-at-rail"): pairs > 2 and rails.any(axis=1).sum() > 1,
            ("layout", "rail"): rails.any(),
            ("layout", "corner"): (rails[:, :2].any(axis=1) & rails[:, 2:].any(axis=1)).any(),
            ("along-rail", "yes"): len(along) > 0,
            ("flight", "jump"): any(ball.velocity[2] > 0.0 for ball in scene.balls),
            ("flight", "drop"): any(ball.position[2] > ball.radius for ball in scene.balls),
            ("flight", "on-top"): any(ball.position[2] > ball.radius for ball in scene.balls),
            ("stop", "t-max"): scene.t_max is not None,
        }
        for option, fact in facts.items():
            if options[option[0]] == option[1]:
                found[option, bool(fact)] += 1
    for option, _ in list(found):
        right, wrong = found[option, True], found[option, False]
        assert right >= 9 * wrong, (option, right, wrong)


def test_every_scene_has_a_ball_that_moves(few):
    assert all(any(ball.speed > 0.0 for ball in scene.balls) for scene in few)
