"""Fails where a shot in flight onto a rack isn't the same each time, or isn't told of."""

import pytest

from benchmarks.flight_racks import Flight, flight_rack, told
from ghostball.engine.scene import POOL_BALL_RADIUS


@pytest.mark.parametrize("number", range(20))
def test_a_shot_comes_from_its_number_and_onto_balls_that_touch(number):
    scene = flight_rack(number)
    assert scene == flight_rack(number)
    assert scene.physics.airborne
    cue = scene.balls[-1]
    assert cue.id == "cue"
    assert cue.position[2] > POOL_BALL_RADIUS or cue.velocity[0] != 0.0


def test_the_slowest_and_what_did_not_rest_are_told():
    flights = [
        Flight("row-drop-0", 1.0, 10, 2, 0, "REST"),
        Flight("b", 3.0, 5, 1, 1, "EVENT_LIMIT"),
    ]
    lines = told(flights).splitlines()
    assert lines[0] == (
        "2 shots: mean 2.00 ms, slowest 3.0 ms, 15 events, 3 contact steps, 1 joint impacts, "
        "1 not to rest"
    )
    assert lines[1].split()[:2] == ["b", "3.0"]
