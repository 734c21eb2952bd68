"""The parts of random scenes are those that their options say, and no others."""

import pytest
from random_layouts import FEW, has, options_in

from ghostball.model.features import Feature, scene_features
from ghostball.validation.scenes.random_scenes import (
    random_scene,
)


@pytest.mark.parametrize("preset", ["carom", "snooker"])
def test_a_preset_that_is_asked_for_brings_no_features_of_its_own(preset):
    for number in FEW:
        scene = random_scene(number, preset=preset, count="few")
        expected = tuple(one for one in Feature if has(one, options_in(scene)))
        assert scene_features(scene) == expected, scene.name
        assert scene.physics.preset == preset
