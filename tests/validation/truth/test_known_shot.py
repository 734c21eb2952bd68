"""The best motion known of a scene."""

import numpy as np
import pytest
from shots import crowded_table
from toy_engines import roll

from ghostball.model import Physics, UnsupportedSceneError
from ghostball.validation import find_scene
from ghostball.validation.truth.known_shot import known_shot


def test_certified_where_it_can_be():
    known = known_shot(find_scene("half-ball-cut"))
    assert known.kind == known.engine == "certified"
    assert known.why == ""
    np.testing.assert_array_equal(known.positions(None), known.rest_positions[:, :2])
    assert known.positions(0.0)[0].tolist() == [0.5, 0.606425]


def in_an_order(name):
    """Return a shipped scene whose impacts at one instant come one after another."""
    scene = find_scene(name)
    physics = scene.physics.model_copy(update={"impacts": "sequential"})
    return scene.model_copy(update={"physics": physics})


@pytest.mark.parametrize(
    ("scene", "kind", "why"),
    [
        (in_an_order("corner-exact"), "closed form", "ambiguous"),
        (find_scene("mathavan-cut"), "our engine", "no closed form"),
    ],
    ids=["ambiguous", "no proof"],
)
def test_else_the_next_best_with_the_reason(scene, kind, why):
    known = known_shot(scene)
    assert known.kind == kind
    assert known.engine == "ghostball"
    assert why in known.why


def test_what_nobody_represents_is_refused():
    with pytest.raises(UnsupportedSceneError, match="at most 53 obstacles"):
        known_shot(
            roll(physics=Physics(motion="sliding", cushion="mathavan2010"), table=crowded_table())
        )
