"""Tests of racks: their places and gaps, the balls that they add to a scene, and bad input."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from ghostball import Ball, Scene, SceneError, Table, rack
from ghostball.model.scene import toml
from ghostball.model.scene.rack import ROWS

R = 0.028575
KINDS = {"3-ball": 3, "6-ball": 6, "8-ball": 15, "9-ball": 9, "10-ball": 10}
CUE = Ball(id="cue", position=(0.5, 0.5), velocity=(9.0, 0.0))

TEXT = """\
schema = 1
name = "break"
table = "bar-7ft"
physics = { preset = "pool" }
[rack]
kind = "8-ball"
seed = 7
[[balls]]
id = "cue"
position = [0.4953, 0.4953]
velocity = [10.5, 0.0]
"""


def gaps_of(balls):
    """Return the gaps of all neighbouring balls."""
    found = []
    for a, b in itertools.combinations(balls, 2):
        gap = math.dist(a.position, b.position) - a.radius - b.radius
        if gap < R:
            found.append(gap)
    return np.array(found)


@pytest.mark.parametrize(("kind", "count"), KINDS.items())
def test_a_rack_has_the_balls_of_its_game_around_the_foot_spot(kind, count):
    balls = rack(kind, "wpa-9ft")
    assert sorted(ball.id for ball in balls) == sorted(str(k) for k in range(1, count + 1))
    assert balls[0].position[:2] == pytest.approx((1.905, 0.635), abs=1e-5)
    assert all(ball.position[0] >= balls[0].position[0] for ball in balls)


def test_the_ball_of_the_game_is_in_the_middle_and_both_groups_in_the_back_corners():
    for kind, ball in (("8-ball", "8"), ("9-ball", "9"), ("10-ball", "10")):
        assert ROWS[kind][2][1] == ball
    left, right = int(ROWS["8-ball"][-1][0]), int(ROWS["8-ball"][-1][-1])
    assert (left < 8) != (right < 8)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("unevenness", [0.0, 0.3, 1.0])
def test_gaps_lie_within_the_stated_range(kind, unevenness):
    gap = 1e-4
    found = np.concatenate(
        [gaps_of(rack(kind, gap=gap, unevenness=unevenness, seed=seed)) for seed in range(20)]
    )
    # The second-order effect of a shift across the line of centres is gap^2 / 4R.
    assert np.min(found) >= gap * (1.0 - unevenness) - 1e-12
    assert np.max(found) <= gap * (1.0 + unevenness) + gap * gap / R
    if unevenness == 1.0:
        assert np.std(found) > 0.2 * gap


def test_presets_set_gap_and_unevenness_and_both_can_be_given():
    assert np.max(gaps_of(rack("8-ball"))) <= 3.001e-5
    assert np.max(gaps_of(rack("8-ball", preset="wooden"))) > 3.001e-5
    assert gaps_of(rack("8-ball", preset="wooden", gap=0.0)) == pytest.approx(0.0, abs=1e-15)


def test_a_seed_gives_the_same_rack_on_every_machine():
    assert rack("9-ball", seed=3) == rack("9-ball", seed=3)
    assert rack("9-ball", seed=3) != rack("9-ball", seed=4)
    x, y, _ = rack("3-ball", gap=1e-3, seed=1)[0].position
    assert (x, y) == (1.9052637746189767, 0.6347550690257394)


def test_a_scene_adds_its_rack_after_the_listed_balls():
    scene = Scene.loads(TEXT)
    assert [ball.id for ball in scene.balls[:2]] == ["cue", "1"]
    assert scene.balls[1:] == rack("8-ball", "bar-7ft", seed=7)
    assert scene.rack is None
    assert Scene.loads(toml.dumps(scene)) == scene
    assert Scene.model_validate_json(scene.model_dump_json()) == scene
    made = Scene(
        name="break",
        table="bar-7ft",
        physics=scene.physics,
        rack={"kind": "8-ball", "seed": 7},
        balls=[Ball(id="cue", position=(0.4953, 0.4953), velocity=(10.5, 0.0))],
    )
    assert made == scene


def test_a_rack_has_the_balls_of_its_table_or_those_that_are_asked_for():
    assert {ball.radius for ball in rack("6-ball", "snooker-12ft")} == {
        Table.BALLS["snooker-12ft"]["radius"]
    }
    assert {ball.radius for ball in rack("6-ball", radius=0.03)} == {0.03}


WRONG = {
    'kind = "8-ball"': ('kind = "7-ball"', "`rack.kind` must be '3-ball'"),
    "seed = 7": ("gap = -1e-6", "`rack.gap` must be at least 0, got -1e-06."),
    "seed =  7": ("gap = nan", "`rack.gap` must be a finite number"),
    "seed = 7 ": ("gap = 0.2", '`rack.kind` = "8-ball" must fit on the table of 1.9812 x 0.9906 m'),
    " seed = 7": ("seed = -1", "`rack.seed` must be at least 0, got -1."),
    " seed = 7 ": ("seed = 1.5", "`rack.seed` must be a whole number, got 1.5."),
    "seed  = 7": ("unevenness = 2.0", "`rack.unevenness` must be at most 1, got 2.0."),
    "seed  =  7": ('preset = "wood"', 'Did you mean "wooden"?'),
    'id = "cue"': ('id = "3"', '`balls[0].id` must not be "3": the 8-ball rack adds a ball'),
    "[0.4953, 0.4953]": (
        "[1.49, 0.4953]",
        '`balls[0].position` must leave room for the 8-ball rack: ball "cue" overlaps its ball "1"',
    ),
    'table = "bar-7ft"': ("", "`rack` must be on a rectangular table, got an unbounded cloth."),
    'table =  "bar-7ft"': (
        "table = { vertices = [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]] }",
        "`rack` must be on a rectangular table, got a polygon.",
    ),
}


@pytest.mark.parametrize(("now", "wrong"), WRONG.items(), ids=[one[0] for one in WRONG.values()])
def test_a_mistake_in_a_rack_is_named_in_one_line(now, wrong):
    instead, message = wrong
    line = " ".join(now.split())
    assert line in TEXT
    with pytest.raises(SceneError) as refused:
        Scene.loads(TEXT.replace(line, instead), "break.toml")
    said = str(refused.value)
    assert message in said
    assert "\n" not in said
    assert said.startswith("break.toml:")


def test_the_function_refuses_what_a_scene_refuses():
    with pytest.raises(SceneError, match="`kind` must be"):
        rack("7-ball")
    with pytest.raises(SceneError, match="must fit on the table"):
        rack("8-ball", Table(length=0.5, width=0.3))
