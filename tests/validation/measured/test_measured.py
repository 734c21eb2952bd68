from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import EventKind, Physics
from ghostball.reference_adapters import make_engine
from ghostball.validation.measured.banks import through_points
from ghostball.validation.measured.cushion_contacts import cushion_contacts
from ghostball.validation.measured.facts import facts_of
from ghostball.validation.measured.oblique_hits import oblique_hit, throw_angle
from ghostball.validation.measured.rebounds import rebounds, square_rebound
from ghostball.validation.measured.rolling import deceleration
from ghostball.validation.measured.simulated_ball import OperatorError, rolling_deceleration
from ghostball.validation.measured.table_agreement import (
    FigureFamily,
    MeasuredEngine,
    agreement_with_tables,
    families_of,
)
from ghostball.validation.measured.tracks import Surface, Track

# Families of hits: speeds and directions after oblique hits, and throw; shown, but not graded


def of(spec, facts):
    engine = make_engine(spec)
    return families_of(facts, MeasuredEngine(engine, partial(engine.simulate, record="trajectory")))


@pytest.mark.parametrize("spec", ["ghostball", "pymunk", "pybullet"])
def test_hits_are_off_by_some_percent_and_degrees(spec):
    speeds, angle = of(spec, "hits-snooker")
    assert not speeds.grades
    assert not angle.grades
    assert {one.what for one in speeds.figures} == {"cue ball", "object ball"}
    assert len(speeds.figures) == 2 * len(angle.figures) == 10
    assert 0.02 < speeds.typical_difference < 0.04
    assert 1.0 < angle.typical_difference < 3.0
    assert speeds.settings == {"ball_restitution": 0.89, "ball_friction": 0.05}


def test_the_hit_that_differs_from_all_models_is_one():
    # A cut of 33.83 degrees, in which the authors' model has the same difference.
    _, angle = of("ghostball", "hits-snooker")
    off = sorted(abs(one.difference) for one in angle.figures)
    assert off[-2] < 1.2
    assert off[-1] > 4.0


def test_throw_is_smaller_than_measured_at_small_cuts_with_any_friction():
    (family,) = of("ghostball", "throw-pool")
    assert not family.grades
    assert len(family.figures) == 6
    assert all(one.difference < -2.0 for one in family.figures)
    assert family.settings["ball_friction"] == "alciatore"
    (family,) = of("pybullet", "throw-pool")
    assert family.settings["ball_friction"] == 0.06


def test_an_engine_whose_balls_only_roll_says_so():
    speeds, angle = of("paper-continuous", "hits-snooker")
    assert speeds.lacks.startswith("it has no sliding that becomes rolling")
    assert angle.lacks == speeds.lacks
    (throw,) = of("paper-continuous", "throw-pool")
    assert throw.lacks.startswith("it has no sliding")


# The operator of slid banks: for simple cushion laws, geometry gives the result


PLAY = partial(simulate, record="trajectory")
ROWS = facts_of("banks-pool").rows
AIMS = [row.at for row in ROWS]
SMOOTH = {"motion": "sliding", "sliding_friction": 0.0, "rolling_friction": 0.0}
ACROSS, BEHIND = 48.25 / 12.5, 4.25 / 12.5


@pytest.mark.parametrize("restitution", [1.0, 0.8])
def test_on_smooth_cloth_the_way_back_is_wider_by_the_restitution(restitution):
    law = {"cushion": "restitution", "cushion_restitution": restitution}
    for aim, found in zip(AIMS, through_points(PLAY, Physics(**SMOOTH, **law), AIMS), strict=True):
        # The ball starts at aim + slope * behind, and returns by slope / restitution * across.
        slope = aim / (ACROSS / restitution - BEHIND)
        assert found == pytest.approx(aim + slope * (ACROSS + 2.0 * BEHIND), rel=1e-6)


@pytest.mark.parametrize("preset", ["pool", "pool-coulomb"])
def test_one_aim_leads_to_the_next_to_a_hundredth_of_a_diamond(preset):
    found = through_points(PLAY, Physics(preset=preset), AIMS)
    alone = [through_points(PLAY, Physics(preset=preset), [aim] * 4)[-1] for aim in AIMS]
    assert found == pytest.approx(alone, abs=0.01)


@pytest.mark.parametrize(("speed", "before"), [(3.0, 0.2), (7.0, 0.2), (4.0, 0.1), (4.0, 0.4)])
def test_a_speed_that_is_not_known_moves_them_by_less_than_tables_differ(speed, before):
    physics = Physics(preset="pool")
    usual = through_points(PLAY, physics, AIMS)
    moved = through_points(PLAY, physics, AIMS, speed=speed, before=before)
    for row, one, other in zip(ROWS, usual, moved, strict=True):
        assert abs(one - other) < 0.8 * row.uncertainty


# The operator of cushion contacts finds known rebounds, and skips contacts near other bodies


SURFACE = Surface(2.84, 1.42, 0.03075)
TIMES = np.arange(0.0, 3.0, 0.02)


def rebound(ratio: float, at: float = 1.0, noise: float = 0.0) -> Track:
    """Return a ball that hits the right cushion with 0.8 m/s across it and 0.3 m/s along it."""
    since = TIMES - at
    away = np.where(since < 0.0, -0.8 * since, 0.8 * ratio * since)
    x = SURFACE.length - SURFACE.radius - away
    positions = np.column_stack([x, 0.3 + 0.3 * TIMES])
    return Track(TIMES, positions + np.random.default_rng(3).normal(0.0, noise, positions.shape))


def test_a_rebound_is_found_with_its_ratio():
    (contact,) = cushion_contacts({"cue": rebound(0.55)}, SURFACE)
    assert (contact.ball, contact.axis) == ("cue", 0)
    assert contact.time == pytest.approx(1.0)
    assert contact.normal_ratio == pytest.approx(0.55, rel=1e-12)
    assert contact.speed_before == pytest.approx(0.8)


def test_noise_of_a_tracker_moves_it_by_less_than_a_percent():
    (contact,) = cushion_contacts({"cue": rebound(0.55, noise=0.0004)}, SURFACE)
    assert contact.normal_ratio == pytest.approx(0.55, abs=0.005)


def test_what_begins_too_late_or_passes_a_ball_does_not_count():
    assert cushion_contacts({"cue": rebound(0.55, at=0.3)}, SURFACE) == []
    near = Track(TIMES, np.tile([2.6, 0.6 + 2.2 * SURFACE.radius], (len(TIMES), 1)))
    assert cushion_contacts({"cue": rebound(0.55), "other": near}, SURFACE) == []


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_ball_that_slides_before_or_after_does_not_count(sign):
    # On heated cloth, a sliding ball decelerates by 0.13 g.
    track = rebound(0.55)
    since = np.maximum(sign * (TIMES - 1.0), 0.0)
    slides = track.positions + np.column_stack([0.0 * since, 0.5 * 0.13 * 9.81 * since**2])
    assert cushion_contacts({"cue": Track(TIMES, slides)}, SURFACE) == []


def test_samples_that_are_missing_or_cover_little_do_not_count():
    track = rebound(0.55)

    def without(first: float, last: float) -> Track:
        kept = (first > TIMES) | (last < TIMES)
        return Track(TIMES[kept], track.positions[kept])

    assert len(cushion_contacts({"cue": without(1.1, 1.25)}, SURFACE)) == 1
    assert cushion_contacts({"cue": without(1.1, 1.35)}, SURFACE) == []
    assert cushion_contacts({"cue": without(0.61, 0.79)}, SURFACE) == []
    assert cushion_contacts({"cue": without(0.9, 1.1)}, SURFACE) == []  # no sample near the cushion


def test_another_cushion_in_the_windows_does_not_count():
    track = rebound(0.55)
    y = SURFACE.radius + np.abs(0.3 * (TIMES - 1.3))
    corner = Track(TIMES, np.column_stack([track.positions[:, 0], y]))
    assert cushion_contacts({"cue": corner}, SURFACE) == []


# Families of cushions: rebounds in two games and banks, for our engine and others


def test_our_engine_comes_near_to_rebounds_of_carom():
    ratio, slope = of("ghostball", "cushion-carom")
    assert len(ratio.figures) == 10
    assert ratio.typical < 1.5
    assert ratio.most < 2.5
    # A law with two numbers doesn't fall exactly like the measured restitution.
    assert 2.0 < slope.most < 3.0


def test_one_restitution_for_all_speeds_is_far_off_and_rises():
    ratio, slope = of("pybullet", "cushion-carom")
    assert ratio.settings["cushion_restitution_loss"] == 0.0
    assert ratio.most > 10.0
    assert all(one.value < 0.0 < one.played for one in slope.figures)


def test_a_ball_that_does_not_bounce_is_said():
    ratio, slope = of("pybullet:config=naive", "cushion-carom")
    assert "bounced 0 times" in ratio.lacks
    assert slope.lacks == ratio.lacks


@pytest.mark.parametrize(("spec", "typical"), [("ghostball", 0.066), ("pybullet", 0.100)])
def test_rebounds_of_snooker_are_shown_in_metres_a_second(spec, typical):
    (family,) = of(spec, "cushion-snooker")
    assert (family.grades, family.unit, len(family.figures)) == (False, "m/s", 8)
    assert family.typical_difference == pytest.approx(typical, abs=0.002)


@pytest.mark.parametrize("spec", ["ghostball", "pymunk", "pybullet"])
def test_banks_are_those_of_a_table(spec):
    (family,) = of(spec, "banks-pool")
    assert family.grades
    assert len(family.figures) == 6
    assert family.most < 1.0


@pytest.mark.parametrize("facts", ["banks-pool", "cushion-snooker"])
def test_an_engine_that_turns_no_balls_says_so(facts):
    (family,) = of("paper-discrete", facts)
    assert family.lacks == "it has no cushion law that changes spin"


# Agreement with measurements: every family, and the families that an engine lacks


GRADED = ["cushion", "cushion-slope", "rolling-pool", "banks-pool"]
GRADED += ["hit-cue-ball", "hit-throw", "head-on-unequal"]
GRADED += ["break-made", "break-scratch", "break-eight"]
SHOWN = ["cushion-snooker", "hit-speeds", "hit-angle", "throw-pool", "throw-frozen"]
SHOWN += ["spin-golf", "rolling-golf"]


def likeness_of(spec: str) -> dict[str, FigureFamily]:
    engine = make_engine(spec)
    found = agreement_with_tables(spec, engine, partial(engine.simulate, record="trajectory"))
    return {family.name: family for family in found.families}


def test_our_engine_plays_everything_that_was_measured():
    families = likeness_of("ghostball")
    assert sorted(families) == sorted(GRADED + SHOWN)
    assert [name for name, one in families.items() if one.grades] == GRADED
    assert not any(family.lacks for family in families.values())


def test_an_engine_that_only_rolls_lacks_it_all():
    families = likeness_of("paper-discrete")
    assert families["cushion"].lacks == "it has no cushion law that changes spin"
    assert families["rolling-pool"].lacks.startswith("it has no sliding that becomes rolling")
    assert not any(family.figures for family in families.values())


@pytest.mark.parametrize("spec", ["ghostball.validation.examples.stepper:Stepper"])
def test_an_engine_that_mentions_few_features_lacks_the_others(spec):
    families = likeness_of(spec)
    assert all(family.lacks for family in families.values())


# Shared code of operators: the deceleration by the cloth, and the balls of each game


def test_a_ball_that_rolls_is_slowed_by_both_parts_of_the_cloth():
    physics = Physics(rolling_friction=0.01, rolling_friction_quadratic=0.02)
    assert rolling_deceleration(physics, 2.0) == pytest.approx(0.0981 + 0.08)


# Rebounds: the preset `carom` agrees with measurements; the operator of square rebounds


@pytest.mark.parametrize("degrees", [5.0, 45.0])
def test_the_preset_carom_keeps_the_measured_ratios(degrees):
    off = [one.errors_off for one in rebounds(PLAY, Physics(preset="carom"), degrees)]
    assert len(off) == 5
    assert max(map(abs, off)) < 2.0


def test_a_restitution_that_is_one_number_rises_where_cushions_fall():
    physics = Physics(preset="carom", cushion_restitution=0.87, cushion_restitution_loss=0.0)
    _, slow, *_, fast = rebounds(PLAY, physics, 5.0)
    assert fast.played > slow.played
    assert fast.value < slow.value


SLIDES = {"motion": "sliding", "rolling_friction": 0.0128, "sliding_friction": 0.21}


@pytest.mark.parametrize("speed", [0.28, 1.0, 3.5])
def test_a_square_rebound_has_the_speeds_right_before_and_after_the_contact(speed):
    # A ball that kept its spin would have (5 e - 2) / 7 = 0.29 of its speed once it rolls again.
    physics = Physics(**SLIDES, cushion="restitution", cushion_restitution=0.8)
    contact = square_rebound(PLAY, physics, speed)
    assert contact.speed_before == pytest.approx(speed, rel=1e-4)
    assert contact.normal_ratio == pytest.approx(0.8, rel=1e-3)


@pytest.mark.parametrize("law", ["frictional", "han2005", "mathavan2010", "stronge2000"])
def test_a_square_rebound_is_the_law_s_own(law):
    seen = []

    def play(scene):
        seen.append(PLAY(scene))
        return seen[-1]

    contact = square_rebound(play, Physics(**SLIDES, cushion=law, cushion_restitution=0.9), 1.5)
    (event,) = (one for one in seen[0].events if one["kind"] == EventKind.BALL_CUSHION)
    instants = np.array([event["t"] - 1e-9, event["t"] + 1e-9])
    before, after = seen[0].sample(instants).velocities[:, 0, 0]
    assert contact.speed_before == pytest.approx(before, rel=1e-3)
    assert contact.speed_after == pytest.approx(-after, rel=2e-3)


# A motion that an operator can't read is an error


def law(restitution: float, along: float = 1.0) -> Physics:
    return Physics(
        **SLIDES,
        cushion="restitution",
        cushion_restitution=restitution,
        cushion_tangential_restitution=along,
    )


def soon_over(scene):
    return PLAY(scene.model_copy(update={"t_max": 0.5}))


@pytest.mark.parametrize(
    ("operator", "said"),
    [
        (lambda: through_points(PLAY, law(0.0), [1.0]), "a bank doesn't come back across"),
        (
            lambda: through_points(PLAY, law(1.0, along=0.05), [1.0]),
            "so steeply that no line of aim leads",
        ),
        (
            lambda: square_rebound(PLAY, law(0.0), 1.0),
            "hit a cushion squarely at 1 m/s left it at",
        ),
        (
            lambda: oblique_hit(PLAY, Physics(motion="sliding", sliding_friction=0.03), 1.5, 30.0),
            r"the cue ball doesn't roll again within 0\.6 s",
        ),
        (
            lambda: throw_angle(PLAY, Physics(motion="sliding"), 0.01, 30.0),
            r"hit at 0\.01 m/s, a cut of 30 degrees",
        ),
        (lambda: deceleration(soon_over, Physics(motion="sliding"), 0.8), "did not roll"),
    ],
)
def test_a_ball_that_does_not_do_what_was_measured_is_said(operator, said):
    with pytest.raises(OperatorError, match=said):
        operator()
