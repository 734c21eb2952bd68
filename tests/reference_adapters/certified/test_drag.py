"""Certified rolling in air, compared with closed forms and Ghostball's engine."""

import numpy as np
import pytest
from flint import arb
from proofs import in_air
from shots import R, ball, scene_of

from ghostball.engine import simulate
from ghostball.model import Scene
from ghostball.reference_adapters.certified import CertifiedSettings, certify
from ghostball.reference_adapters.certified.arithmetic import working_precision
from ghostball.reference_adapters.certified.drag import Roll, first_entry_of
from ghostball.reference_adapters.certified.roots import NONE, ROOT, UNSURE
from ghostball.validation.scenes.library import find_scene

AIR = {"air_drag": 0.0041, "rolling_friction_quadratic": 0.006}


@pytest.mark.parametrize(
    ("physics", "time", "displacement"),
    [
        ({"rolling_friction": 0.02}, 9.9231021048020829, 9.7899900947054689),
        ({"rolling_friction": 0.01, "motion": "sliding"}, 19.629465424815389, 19.259093295102175),
    ],
)
def test_a_roll_ends_where_worked_numbers_say(
    physics: dict, time: float, displacement: float
) -> None:
    scene = scene_of(ball((0, 0), (2.0, 0.0)), air_drag=0.0041, gravity=9.81, **physics)
    certificate = certify(scene, cached=False)
    assert certificate.proved
    assert float(certificate.t_end) == pytest.approx(time, rel=1e-15)
    assert float(certificate.positions[0][0]) == pytest.approx(displacement, rel=1e-15)


def test_a_roll_that_nothing_stops_continues() -> None:
    scene = scene_of(ball((0, 0), (2.0, 0.0)), air_drag=0.5, rolling_friction=0.0, t_max=3.0)
    certificate = certify(scene, cached=False)
    assert float(certificate.positions[0][0]) == pytest.approx(np.log1p(3.0) / 0.5, rel=1e-15)
    assert float(certificate.velocities[0][0]) == pytest.approx(0.5, rel=1e-15)


def test_our_engine_plays_every_proved_event_of_a_break_in_air() -> None:
    scene, count = in_air(find_scene("break-16"), **AIR), 60
    settings = CertifiedSettings(max_events=count)
    certificate, run = certify(scene, settings, cached=False), simulate(scene, record="events")
    assert len(certificate.events) == count
    for proved, found in zip(certificate.events, run.events[:count], strict=True):
        assert (proved.kind, proved.a, proved.b) == (found["kind"], found["a"], found["b"])
        assert float(proved.t) == pytest.approx(found["t"], abs=1e-8)


def test_a_whole_break_is_proved() -> None:
    scene = in_air(find_scene("break-7"), **AIR)
    certificate, run = certify(scene, cached=False), simulate(scene)
    assert certificate.proved
    rest = np.array([[float(x) for x in place] for place in certificate.positions])
    assert np.abs(rest - run.rest_positions[:, :2]).max() < 1e-11


def test_a_cloth_that_slows_fast_balls_more_is_proved_where_balls_slide_too() -> None:
    scene = find_scene("half-ball-rolling")
    physics = scene.physics.model_copy(update={"rolling_friction_quadratic": 0.006})
    slides = Scene(**{**dict(scene), "physics": physics})
    assert certify(slides, cached=False).proved


def test_ranges_of_a_roll_hold_its_values() -> None:
    with working_precision(106):
        roll = Roll(arb(2), arb("0.2"), arb("0.01"))
        span = arb("1.5").union(arb("2.5"))
        for s in ("1.5", "1.7", "2.2", "2.5"):
            assert roll.displacement(span).contains(roll.displacement(arb(s)).mid())
            assert roll.speed(span).contains(roll.speed(arb(s)).mid())
        assert roll.speed(arb(1000)) == 0


def test_a_search_finds_the_first_entry_and_gives_up_where_it_grazes() -> None:
    with working_precision(106):
        zero, end = arb(0), arb(4)
        twice = first_entry_of(lambda s: (s - 1) * (s - 3), lambda s: 2 * s - 4, zero, end, 53)
        assert twice.verdict == ROOT
        assert twice.low < 1 < twice.high < 3
        open_ = first_entry_of(lambda s: (s - 2) ** 2 + 1, lambda s: 2 * s - 4, zero, end, 53)
        assert open_.verdict == NONE
        grazes = first_entry_of(lambda s: (s - 2) ** 2, lambda s: 2 * s - 4, zero, end, 53)
        assert grazes.verdict == UNSURE
        assert grazes.low <= 2 + arb(R)
