"""Sliding in air, proved: against worked numbers, another solver, and our engine."""

import math

import numpy as np
import pytest
from flint import arb
from proofs import engine_keys, in_air, keys
from shots import POOL_TABLE, R, ball, random_cloth_shot, scene_of

from ghostball.engine import simulate
from ghostball.model import EventKind, Scene, UnsupportedSceneError
from ghostball.reference_adapters.certified import CertifiedSettings, certify
from ghostball.reference_adapters.certified.arithmetic import (
    UndecidedError,
    working_precision,
)
from ghostball.reference_adapters.certified.slide import Slide
from ghostball.reference_adapters.certified.slide_piece import (
    State,
    next_piece,
)

K = 0.0041
POOL = {"preset": "pool", "air_drag": K, "gravity": 9.81, "sliding_friction": 0.2}
A = 0.2 * 9.81


def slide_of(v, u, friction=A, drag=K) -> Slide:
    return Slide((arb(v[0]), arb(v[1])), (arb(u[0]), arb(u[1])), arb(friction), arb(drag))


# -- worked numbers ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("spin", "time", "place", "velocity"),
    [
        ((0.0, 0.0), 0.43514440820822335, (1.1168116256280046, 0.0), (2.1343833222613356, 0.0)),
        (
            (-50.0, 60.0),
            0.27906760072226945,
            (0.78488866111409261, 0.056830779037561494),
            (2.6262173230896689, 0.40775401791915693),
        ),
    ],
)
def test_a_slide_ends_where_worked_numbers_say(spin, time, place, velocity) -> None:
    with working_precision(106):
        wx, wy = spin
        radius = arb(R)
        slide = Slide(
            (arb(3), arb(0)),
            (3 - radius * wy, radius * wx),
            arb("0.2") * arb("9.81"),
            arb("0.0041"),
        )
        found = (slide.duration, *slide.end, *slide.final_velocity)
        for enclosure, worked in zip(found, (time, *place, *velocity), strict=True):
            assert float(enclosure) == pytest.approx(worked, rel=1e-15)
            assert enclosure.rad() < 1e-27


def test_the_end_of_a_slide_is_an_event_of_its_shot() -> None:
    scene = scene_of(ball((0, 0), (3.0, 0.0), angular_velocity=(-50.0, 60.0, 0.0)), **POOL)
    certificate = certify(scene, cached=False)
    assert certificate.proved
    assert [e.kind for e in certificate.events] == [
        EventKind.SLIDE_TO_ROLL,
        EventKind.ROLL_TO_REST,
    ]
    assert float(certificate.events[0].t) == pytest.approx(0.27906760072226945, rel=1e-15)


# -- another solver ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("v", "u", "drag"),
    [
        ((1.5, 0.0), (6.9, 0.0), K),  # drawn back along a line: it stands still for an instant
        ((0.0, 0.0), (-3.0, 1.0), K),  # from rest
        ((3.0, 1.0), (2.0, -3.0), 10.0),  # the air slows it more than the cloth
    ],
)
def test_more_precision_lies_within_less(v, u, drag) -> None:
    with working_precision(53):
        wide = slide_of(v, u, drag=drag)
    with working_precision(159):
        narrow = slide_of(v, u, drag=drag)
        pairs = [
            (wide.duration, narrow.duration),
            *zip(wide.end, narrow.end, strict=True),
            *zip(wide.final_velocity, narrow.final_velocity, strict=True),
        ]
        for part in ("0.0", "0.3", "0.77", "0.99", "0.9999999"):
            s = (arb(part) * narrow.duration).mid()
            for name in ("displacement", "velocity", "slip"):
                pairs += zip(getattr(wide, name)(s), getattr(narrow, name)(s), strict=True)
        for outer, inner in pairs:
            assert outer.contains(inner)
            assert outer.rad() < 1e-7
            assert inner.rad() < 1e-20


# -- enclosures ----------------------------------------------------------------------------------


def test_a_slide_that_begins_in_balls_holds_all_that_begin_in_them() -> None:
    """Nothing is magnified: an error at the start is one in the end."""
    v, u, width = (2.0, 0.25), (1.5, -1.75), 1e-6
    with working_precision(106):
        wide = Slide(
            (arb(v[0], width), arb(v[1], width)), (arb(u[0], width), arb(u[1], width)),
            arb(A), arb(K),
        )  # fmt: skip
        assert wide.final_velocity[0].rad() < 12 * width
        for signs in ((0, 0, 0, 0), (1, 1, 1, 1), (0, 1, 1, 0), (1, 0, 0, 1)):
            vx, vy, ux, uy = (
                x + (2 * s - 1) * 0.99 * width for x, s in zip((*v, *u), signs, strict=True)
            )
            one = slide_of((vx, vy), (ux, uy))
            assert wide.duration.contains(one.duration)
            for name in ("end", "final_velocity"):
                for outer, inner in zip(getattr(wide, name), getattr(one, name), strict=True):
                    assert outer.contains(inner)
            s = arb(one.duration.mid() / 2)
            for outer, inner in zip(wide.displacement(s), one.displacement(s), strict=True):
                assert outer.contains(inner)


def test_ranges_of_a_slide_hold_its_values() -> None:
    with working_precision(106):
        slide = slide_of((2.0, 0.25), (1.5, -1.75))
        end = slide.duration.mid()
        marks = [
            (end * arb(part)).mid() for part in ("0", "0.2", "0.5", "0.999", "0.99999999", "1.2")
        ]
        for i, low in enumerate(marks):
            for high in marks[i + 1 :]:
                span = low.union(high)
                for part in ("0", "0.21", "0.5", "0.83", "1"):
                    s = (low + (high - low) * arb(part)).mid()
                    for name in ("displacement", "velocity", "slip"):
                        ranges, values = getattr(slide, name)(span), getattr(slide, name)(s)
                        for outer, inner in zip(ranges, values, strict=True):
                            assert outer.contains(inner.mid())
        beyond = (end + 1).mid()
        assert slide.velocity(beyond)[0].overlaps(slide.final_velocity[0])
        assert slide.slip(beyond)[0].is_zero()


def test_a_slip_that_may_be_nothing_is_not_decided() -> None:
    with pytest.raises(UndecidedError, match="whether it slides or rolls"):
        Slide((arb(1), arb(0)), (arb("1e-9", 1e-9), arb(0)), arb(A), arb(K))
    state = State.of((arb(1), arb(0)), (arb(0, 1e-9), arb("1e-9")))
    with pytest.raises(UndecidedError, match="whether it slides or rolls"):
        next_piece(state, arb(A), arb(K), arb(1e-20))


# -- shots ---------------------------------------------------------------------------------------


def test_our_engine_plays_every_proved_event() -> None:
    """Sliding balls, with spin about any axis, meet balls and cushions and each other."""
    scene = in_air(random_cloth_shot(12), air_drag=1.0)
    certificate, run = certify(scene, cached=False), simulate(scene, record="events")
    assert certificate.proved
    assert keys(certificate) == engine_keys(scene)
    for proved, t in zip(certificate.events, run.events["t"], strict=True):
        assert float(proved.t) == pytest.approx(t, abs=1e-10)
    rest = np.array([[float(x) for x in place] for place in certificate.positions])
    assert np.abs(rest - run.rest_positions[:, :2]).max() < 1e-10


def test_a_slide_without_friction_goes_straight_on() -> None:
    scene = scene_of(
        ball((0, 0), (2.0, 0.0), angular_velocity=(10.0, 0.0, 0.0)), ball((0, 1)),
        **POOL | {"sliding_friction": 0.0, "air_drag": 0.5}, t_max=3.0,
    )  # fmt: skip
    certificate = certify(scene, cached=False)
    assert certificate.proved
    assert float(certificate.positions[0][0]) == pytest.approx(math.log(4.0) / 0.5, rel=1e-15)
    assert float(certificate.velocities[0][0]) == pytest.approx(0.5, rel=1e-15)
    assert float(certificate.spins[0][0]) == pytest.approx(10.0, rel=1e-15)


# -- contact -------------------------------------------------------------------------------------


def on_cushion(spin: float, vx: float = 0.0) -> Scene:
    return scene_of(
        ball((0.5, R), (vx, 0.0), angular_velocity=(spin, 0.0, 0.0)), table=POOL_TABLE, **POOL
    )


def test_friction_presses_a_ball_into_a_cushion_in_air() -> None:
    certificate = certify(on_cushion(50.0), cached=False)
    assert certificate.ending == "sustained contact"
    assert "in resting contact" in certificate.reason


def test_a_ball_slides_along_a_cushion_in_air() -> None:
    certificate = certify(on_cushion(0.0, 0.5), cached=False)
    assert certificate.proved
    assert len(certificate.events) == 2


# -- limits --------------------------------------------------------------------------------------


def test_a_slide_at_a_speed_that_hardly_changes_is_refused_by_name() -> None:
    """On a cloth so slippery, in air so thick, it takes years, at its terminal speed."""
    slippery = ball((0, 0), (2.0, 1.0), angular_velocity=(0.0, 700.0, 0.0))
    scene = scene_of(slippery, **POOL | {"air_drag": 0.01, "gravity": 1e-6})
    with pytest.raises(UnsupportedSceneError, match="whose slide in air takes more than"):
        certify(scene, cached=False)


def test_a_slip_that_ends_at_a_speed_too_high_to_roll_at_is_refused_by_name() -> None:
    """The air slows it by 100 m/s^2: what the cloth can take of that is less than it has to."""
    scene = scene_of(
        ball((0, 0), (100.0, 0.0), angular_velocity=(0.0, 99.0 / R, 0.0)),
        **POOL | {"air_drag": 0.01},
    )
    with pytest.raises(UnsupportedSceneError, match="by more than it can roll with"):
        certify(scene, cached=False)


def test_the_time_limit_ends_a_proof_between_pieces() -> None:
    """An exact tie continues to the last precision, where one slide would take an hour."""
    scene = scene_of(
        ball((0.5, 0.5), (-1.0, -1.0), angular_velocity=(0.0, 0.0, 0.0)),
        table=POOL_TABLE.model_copy(update={"width": 2.54}),
        **POOL,
    )
    certificate = certify(scene, CertifiedSettings(time_limit=0.5), cached=False)
    assert certificate.ending == "time limit"
    assert certificate.precision < CertifiedSettings().max_precision
