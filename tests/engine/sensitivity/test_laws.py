"""Tests of the effect of impacts on small changes, by central differences of whole shots."""

from __future__ import annotations

import pytest
from changes import check_derivatives, recorded
from shots import ball, scene_of

from ghostball.model import EventKind, partner_name
from ghostball.validation.scenes.library import find_scene

SCENES = (
    "around-the-table",
    "break-16",
    "draw-shot",
    "masse",
    "moving-moving",
    "pool-break-9",
    "mathavan-cut",
    "restitution-cut",
    "throw-alciatore",
    "throw-slip",
    "throw-stick",
    "unequal-balls",
)


@pytest.mark.parametrize("name", SCENES)
def test_derivatives_agree_with_central_differences(name):
    """Compare with differences of the engine's own shots, at many times, for every ball."""
    check_derivatives(find_scene(name))


ELL = [[0, 0], [2, 0], [2, 0.8], [1.1, 0.9], [1.0, 1.7], [0, 1.6]]


@pytest.mark.parametrize(
    ("table", "position", "velocity", "met"),
    [
        pytest.param("wpa-9ft", (0.6, 0.635), (3.7, -1.6), {"bottom", "top", "right"}, id="jaws"),
        pytest.param("wpa-9ft", (0.6, 0.635), (1.3, -1.14), {"bottom"}, id="pocketed"),
        pytest.param({"vertices": ELL}, (1.6, 0.4), (-1.2, 1.2), {"side-3"}, id="corner"),
        pytest.param(
            {"length": 2, "width": 1, "posts": [{"centre": (1, 0.5), "radius": 0.1}]},
            (0.3, 0.45),
            (2.0, 0.1),
            {"post-1"},
            id="post",
        ),
    ],
)
@pytest.mark.parametrize("cushion", ["restitution", "han2005", "stronge2000"])
def test_derivatives_through_what_is_not_a_line(table, position, velocity, met, cushion):
    """A jaw, an inward corner and a post turn the normal; in a hole the motion ends."""
    scene = scene_of(
        ball(position, velocity, angular_velocity=(3.0, -5.0, 20.0)),
        table=table,
        motion="sliding",
        cushion=cushion,
    )
    result = recorded(scene)
    named = {partner_name(EventKind(e["kind"]), e["b"]) for e in result.events if e["b"] >= 0}
    assert met <= named
    check_derivatives(scene)


def test_derivatives_through_a_restitution_that_falls_with_speed():
    scene = find_scene("three-cushions")
    physics = scene.physics.model_copy(update={"rolling_friction_quadratic": 0.0})
    check_derivatives(scene.model_copy(update={"physics": physics}))
