"""Fails where a curve has wrong points, a slow peer is asked on, or a reason is lost."""

import itertools

import pytest
from peers import FakePeer

from benchmarks import scaling
from benchmarks.peer_engines import PeerCannotError, PeerFailedError
from benchmarks.scaling import TINY, Extent, measure_scaling, scene_of

SMALL = Extent((2, 4, 8), (0.2,), fixed_balls=4, least_events=1, least_peer_events=1)


def of_engine(points, engine, physics="gas"):
    return [point for point in points if (point.engine, point.physics) == (engine, physics)]


def clock_that_takes(seconds):
    count = itertools.count()
    return lambda: seconds * next(count)


def test_our_engine_and_peers_have_a_point_at_each_place():
    peer = FakePeer("peer", seconds=3.0, events=6)
    measured = measure_scaling([peer], rounds=2, extent=TINY)
    for engine in ("ghostball", "peer"):
        for physics in ("gas", "cloth"):
            points = of_engine(measured.by_balls, engine, physics)
            assert [point.balls for point in points] == [2, 4]
            points = of_engine(measured.by_packing, engine, physics)
            assert [(p.packing, p.balls) for p in points] == [(0.1, 4), (0.3, 4)]
    point = of_engine(measured.by_balls, "peer")[0]
    assert (point.per_event, point.samples) == (0.5, 2)
    assert {curve.outcome for curve in measured.curves} == {"ran"}
    assert measured.quick


def test_few_balls_make_several_scenes_of_one_sample():
    peer = FakePeer("peer")
    extent = Extent((2,), (), fixed_balls=2, least_events=1, least_peer_events=7)
    measure_scaling([peer], rounds=1, extent=extent)
    scenes = {scene.model_dump_json() for scene in peer.asked}
    assert len(scenes) == 2 * 4  # 2 expected events each, gas and cloth


def test_a_slow_peer_goes_no_further_and_ours_does():
    peer = FakePeer("peer", seconds=3.0, events=6)
    clock = clock_that_takes(scaling.LONGEST_SAMPLE + 1.0)
    measured = measure_scaling([peer], rounds=3, extent=SMALL, clock=clock)
    assert [(p.balls, p.samples) for p in of_engine(measured.by_balls, "peer")] == [(2, 1)]
    assert [p.balls for p in of_engine(measured.by_balls, "ghostball")] == [2, 4, 8]
    (curve,) = (c for c in measured.curves if (c.engine, c.physics) == ("peer", "gas"))
    assert curve.detail == "no further: 6 s for 2 balls"


def test_a_peer_that_cannot_has_its_reason_and_no_points():
    peer = FakePeer("peer", error=PeerCannotError("no cloth"))
    measured = measure_scaling([peer], rounds=2, extent=SMALL)
    assert of_engine(measured.by_balls, "peer") == []
    curves = [curve for curve in measured.curves if curve.engine == "peer"]
    assert [(c.outcome, c.detail) for c in curves] == [("not-representable", "no cloth")] * 2
    assert len(peer.asked) == 2


def test_a_peer_that_fails_with_many_keeps_its_points_with_few():
    peer = FakePeer("peer", seconds=3.0, error=PeerFailedError("out of memory"), from_balls=4)
    measured = measure_scaling([peer], rounds=1, extent=SMALL)
    assert [p.balls for p in of_engine(measured.by_balls, "peer")] == [2, 4]
    (curve,) = (c for c in measured.curves if (c.engine, c.physics) == ("peer", "gas"))
    assert (curve.outcome, curve.detail) == ("ran", "not with 8 balls: out of memory")


def test_a_run_without_events_is_no_point():
    measured = measure_scaling([FakePeer("peer", events=0)], rounds=1, extent=TINY)
    assert of_engine(measured.by_balls, "peer") == []


def test_an_interrupt_keeps_what_is_there():
    peer = FakePeer("peer", error=KeyboardInterrupt(), from_balls=2)
    measured = measure_scaling([peer], rounds=1, extent=SMALL)
    assert measured.interrupted
    assert [p.balls for p in of_engine(measured.by_balls, "ghostball")] == [2, 4]


@pytest.mark.parametrize("physics", ["gas", "cloth"])
def test_scenes_begin_alike_however_long_they_last(physics):
    short, long = (scene_of(physics, 4, 0.3, 1, collisions) for collisions in (1.0, 3.0))
    assert long.t_max == pytest.approx(3.0 * short.t_max)
    assert short.balls == long.balls
