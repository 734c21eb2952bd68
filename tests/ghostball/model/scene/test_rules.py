"""The rules between the balls of a scene and its table: where a ball may be."""

from __future__ import annotations

import numpy as np
import pytest
from refusals import refusal
from shots import POOL_TABLE, R, ball, rack, scene_of

from ghostball.model import CUSHIONS, Table
from ghostball.model.rounding import FLIGHT_CONTACT_TOLERANCE
from ghostball.model.scene.rules import overlaps


class TestBallsTogether:
    def test_two_balls_of_one_name(self):
        message = refusal(ball((0, 0), id="cue"), ball((1, 0)), ball((2, 0), id="cue"))
        assert '`balls[2].id` must be unique, but `balls[0]` is called "cue" too' in message

    def test_overlap_names_both_balls_and_its_size(self):
        message = refusal(ball((0, 0), id="cue"), ball((1, 0)), ball((0.05, 0), id="eight"))
        assert '`balls[0]` ("cue") and `balls[2]` ("eight")' in message
        assert f"{2 * R - 0.05:.6g} m" in message
        assert "Move one" in message

    def test_the_reach_of_unequal_balls_is_the_sum_of_their_radii_in_the_plane(self):
        # In space the centres are farther apart than in the plane, as their heights differ.
        scene_of(ball((0, 0), radius=0.25), ball((0.75, 0), radius=0.5))
        assert "overlap" in refusal(ball((0, 0), radius=0.25), ball((0.74, 0), radius=0.5))

    @pytest.mark.parametrize("apex", [(0.0, 0.0), (1.905, 0.635), (17.3, -4.1)])
    def test_a_touching_rack_computed_from_sqrt_3_is_accepted(self, apex):
        assert len(scene_of(*rack(15, apex, gap=0.0)).balls) == 15

    def test_the_worst_overlap_of_a_ball_is_the_one_reported(self):
        message = refusal(ball((0, 0)), ball((0.1, 0)), ball((0.06, 0)))
        assert "`balls[1]`" in message
        assert "`balls[2]`" in message


def test_every_overlap_is_found_and_no_other():
    """Against each ball compared with each other, in forty shots at a time."""
    chance = np.random.default_rng(1)
    for count in (1, 2, 3, 8, 30):
        centres = chance.uniform(0.0, 1.0, (40, count, 2))
        radii = chance.uniform(0.01, 0.2, count)
        distance = np.linalg.norm(centres[:, :, None] - centres[:, None], axis=3)
        overlap = radii[:, None] + radii - distance
        found = overlaps(centres, radii)
        assert (
            sorted(list(pair[:3]) for pair in found)
            == np.argwhere(np.tril(overlap > 1e-12, -1)).tolist()
        )
        assert [pair[:2] for pair in found] == sorted(pair[:2] for pair in found)


@pytest.mark.parametrize(
    ("cushion", "place"),
    [
        ("left", (0.02, 0.6)),
        ("right", (2.53, 0.6)),
        ("bottom", (1.0, 0.0)),
        ("top", (1.0, 1.3)),
        # By hardly more than rounding, and by far.
        ("left", (R - 1e-9, 0.6)),
        ("right", (2.54 - R + 1e-9, 0.6)),
        ("bottom", (1.0, R - 1e-9)),
        ("top", (1.0, 1.27 - R + 1e-9)),
        ("right", (1e6, 0.6)),
        ("bottom", (1.0, -1e6)),
    ],
)
def test_a_ball_outside_the_table(cushion, place):
    message = refusal(ball((1, 0.3)), ball(place, id="lost"), table=POOL_TABLE)
    assert "`balls[1].position` must be inside the table" in message
    assert '"lost"' in message
    assert f"beyond the {cushion} cushion" in message


@pytest.mark.parametrize("name", CUSHIONS)
def test_a_side_without_a_cushion_is_open(name):
    places = {"left": (-9, 1), "right": (9, 1), "bottom": (1, -9), "top": (1, 9)}
    others = tuple(other for other in CUSHIONS if other != name)
    table = Table(length=2, width=2, cushions=others)
    assert scene_of(ball(places[name]), table=table).table == table


def test_a_ball_in_the_air_needs_airborne():
    assert "z must be the radius" in refusal(ball((0, 0, 0.1)))
    assert "z must be 0, got 1.0 m/s" in refusal(ball((0, 0), (0, 0, 1)))
    flies = scene_of(ball((0, 0, 0.1), (0, 0, 1)), motion="sliding", airborne=True)
    assert flies.balls[0].position[2] == 0.1


def test_no_ball_is_inside_the_table_or_begins_into_it():
    inside = {"motion": "sliding", "airborne": True}
    sunk = refusal(ball((0, 0, R - 1e-3)), **inside)
    assert "z must be at least the radius" in sunk
    assert "the ball would be 0.001 m inside the table" in sunk
    assert "z must be at least 0 of a ball that lies" in refusal(
        ball((0, 0), (0, 0, -1e-9)), **inside
    )
    assert scene_of(ball((0, 0, 1.1 * R), (0, 0, -1)), **inside).balls[0].velocity[2] == -1.0


def test_a_ball_above_a_cushion_may_be_nearer_to_it():
    fields = {"motion": "sliding", "airborne": True, "table": POOL_TABLE}
    on_nose = 0.0357 + R
    scene_of(ball((1e-3, 0.5, on_nose)), **fields)
    assert "beyond the left cushion" in refusal(ball((1e-3, 0.5, 0.99 * on_nose)), **fields)
    assert "beyond the left cushion" in refusal(ball((-1e-3, 0.5, 2 * on_nose)), **fields)
    # On the cloth, at sqrt(h (2 R - h)): a little less than its radius.
    scene_of(ball((0.97 * R, 0.5)), **fields)
    assert "so far at this height" in refusal(ball((0.96 * R, 0.5)), **fields)


def test_balls_above_each_other_do_not_overlap_in_the_air():
    scene_of(ball((0, 0)), ball((0, 0, 3.5 * R)), motion="sliding", airborne=True)
    fields = {"motion": "sliding", "airborne": True}
    assert "overlap" in refusal(ball((0, 0)), ball((0, 0, 2.5 * R)), **fields)


def test_a_ball_in_the_air_may_lie_on_another_as_deep_as_our_engine_lets_it():
    fields = {"motion": "sliding", "airborne": True}
    below, deep = ball((0, 0)), 0.99 * FLIGHT_CONTACT_TOLERANCE * 2.0 * R
    scene_of(below, ball((0, 0, 3.0 * R - deep)), **fields)
    assert "overlap" in refusal(below, ball((0, 0, 3.0 * R - 1.1 * deep)), **fields)
    assert "overlap" in refusal(below, ball((2.0 * R - deep, 0)), **fields)
    assert "overlap" in refusal(below, ball((2.0 * R - deep, 0)))


@pytest.mark.parametrize("place", [(1e14, 0), (0, -1e14)])
def test_a_place_where_rounding_is_larger_than_a_ball(place):
    # Two balls in one place would pass for touching there.
    message = refusal(ball((0, 0)), ball(place))
    assert "`balls[1].position` must be known to better than the radius, 0.028575 m" in message
    assert "rounds by up to 0.36 m" in message
    assert "must not overlap" in refusal(ball((1e12, 0)), ball((1e12, 0)))
