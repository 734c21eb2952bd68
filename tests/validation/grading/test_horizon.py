"""The horizon depends on the engine's errors; after the horizon, ends of shots aren't compared."""

from __future__ import annotations

import math

import numpy as np
import pytest
from step_rules import asked_of_all

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Scene, Table
from ghostball.reference_adapters import make_engine
from ghostball.reference_adapters.base import EngineBase, resolution_of, stated_error
from ghostball.reference_adapters.certified import certify
from ghostball.reference_adapters.ghostball import GhostballEngine
from ghostball.validation.checks.criteria import Criteria, common_criteria
from ghostball.validation.checks.metrics import METRICS
from ghostball.validation.checks.requirements import asked_of
from ghostball.validation.checks.verdict import Verdict, verdict_of
from ghostball.validation.grading.certified_growth import growth_of_certificate
from ghostball.validation.grading.horizon import Meetings, RunGrowth, horizon, meetings_of
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.suite.case import run_case
from ghostball.validation.suite.judge import Case
from ghostball.validation.truth.scene_truth import truth_of


def horizon_of(name: str, label: str) -> float:
    scene = find_scene(name)
    run = simulate(scene, record="trajectory")
    return meetings_of(RunGrowth(run), run).horizon(
        stated_error(resolution_of(make_engine(label), scene))
    )


def test_the_horizon_is_where_the_size_passes_the_limit():
    scene = find_scene("chaos-a")
    growth = growth_of_certificate(scene, certify(scene, motion=True))
    ends = horizon(growth, 1e-3, 2.0**-48)
    assert 0.0 < ends < growth.t_end
    assert 2.0**-48 * np.max(growth.sizes([ends - 1e-5])) <= 1e-3
    assert 2.0**-48 * np.max(growth.sizes([ends + 1e-5])) > 1e-3
    assert horizon(growth, 1e-6, 2.0**-48) < ends
    assert horizon(growth, 1e60, 2.0**-48) == math.inf


@pytest.mark.parametrize(
    ("name", "ends"), [("three-ball-symmetric", 0.45), ("push", 0.0), ("chaos-a", math.inf)]
)
def test_our_run_knows_from_when_on_it_has_no_derivative(name, ends):
    run = simulate(find_scene(name), record="trajectory")
    growth = RunGrowth(run)
    assert (growth.derivative_ends < math.inf) == (ends < math.inf)
    assert growth.derivative_ends >= ends
    known = growth.times[growth.times < growth.derivative_ends]
    assert np.isfinite(growth.sizes(known)).all()


def test_a_run_and_a_proof_have_the_same_horizon_but_for_roundings():
    scene = find_scene("chaos-a")
    growths = (
        RunGrowth(simulate(scene, record="trajectory")),
        growth_of_certificate(scene, certify(scene, motion=True)),
    )
    ours, proved = (horizon(growth, 1e-3, 2.0**-48) for growth in growths)
    assert ours == pytest.approx(proved, rel=0.05)


def test_who_errs_more_has_the_shorter_horizon():
    labels = (
        "ghostball",
        "pymunk:contact_steps=exact",
        "pymunk:dt=1e-6",
        "pymunk",
        "pymunk:dt=1e-2",
    )
    horizons = [horizon_of("chaos-a", label) for label in labels]
    assert horizons == sorted(horizons, reverse=True)
    assert horizons[0] > 2.0 * horizons[2] > 0.0


def test_the_horizon_is_the_first_meeting_where_errors_pass_a_radius():
    # An error of 1 mm has grown to 20 mm at the first meeting, and to 40 mm at the second.
    largest = np.array([20.0, 40.0, 100.0])
    meetings = Meetings(np.array([1.0, 2.0, 3.0]), largest, extent=1.0, radius=0.03)
    assert meetings.horizon(1e-3) == 2.0


def test_what_all_but_happens_leaves_a_shot_predictable():
    """Fails if a near miss shortens the horizon, although errors don't grow there."""
    for label in ("ghostball", "pymunk", "pymunk:dt=1e-2", "paper-discrete"):
        assert horizon_of("half-ball-cut", label) == math.inf
    assert horizon_of("break-7", "pymunk") == math.inf


def test_a_contact_at_which_steps_end_is_off_by_its_gap():
    scene = find_scene("break-7")
    assert resolution_of(make_engine("pymunk:contact_steps=exact"), scene) == 1e-10
    assert resolution_of(make_engine("pymunk:dt=1e-4"), scene) == pytest.approx(2e-4)
    assert resolution_of(make_engine("ghostball"), scene) == 0.0
    assert resolution_of(make_engine("certified"), scene) == "proved"


def test_who_states_nothing_is_not_taken_to_be_exact_and_excused_from_nothing():
    class Protocol:
        """An engine without the base class `EngineBase` and without `resolution`."""

    class Silent(GhostballEngine):
        resolution = EngineBase.resolution

    class Stated(Protocol):
        def resolution(self, scene):
            return 1e-3

    scene = find_scene("chaos-a")
    assert resolution_of(Protocol(), scene) is None
    assert resolution_of(Silent(), scene) is None
    assert resolution_of(Stated(), scene) == 1e-3
    truth = truth_of(scene, parts=("rest",))
    assert truth.horizon_of(None) == truth.horizon_of(0.0) > truth.horizon_of(1e-3)
    assert truth.horizon_of("proved") == math.inf


@pytest.mark.parametrize(
    ("name", "ends"),
    [
        ("chaos-a", 5.4499),  # rounding errors have grown to a millimetre
        ("half-ball-cut", math.inf),
        ("frozen-to-cushion", math.inf),  # a closed form, with two simultaneous collisions
    ],
)
def test_a_shot_has_a_horizon_of_its_own_whatever_the_engine(name, ends):
    assert truth_of(find_scene(name)).shot_horizon == pytest.approx(ends, abs=1e-4)


def test_past_its_horizon_nothing_is_said_of_how_a_shot_ends():
    scene = find_scene("break-16")
    truth = truth_of(scene)
    near, _ = run_case(Case(scene, "pymunk:contact_steps=exact", truth))
    far, _ = run_case(Case(scene, "pymunk", truth))
    assert near.horizon is None
    assert near.metrics["rest_error_max"] < 1e-4
    assert far.horizon == pytest.approx(1.4837, abs=1e-3)
    ends = [name for name, metric in METRICS.items() if metric.judges == "end"]
    assert {far.metrics[name] for name in ends} == {None}
    assert all("after the horizon" in far.notes[name] for name in ends)
    assert far.ball_errors is None
    assert far.metrics["matching_events"] >= 0
    # At its horizon the engine already has wrong collisions, so this error is larger than error
    # growth explains.
    assert far.metrics["energy_difference_max"] == pytest.approx(0.0739, rel=0.01)


def test_a_closed_form_is_compared_with_whatever_errors_become():
    scene = find_scene("galperin-2")
    record, _ = run_case(Case(scene, "pymunk:config=naive", truth_of(scene)))
    assert record.horizon is None


def test_a_run_that_stops_early_fails_what_every_scene_asks():
    """Fails if a criterion is dropped because a bad run leaves nothing to measure."""
    scene = find_scene("half-ball-cut")
    rows = common_criteria().applying_to("ghostball", {}, "rounding")
    graded = asked_of_all([one for one in rows if one.metric == "quality_factor"])
    record, _ = run_case(Case(scene, "ghostball:max_events=1", truth_of(scene), graded))
    assert [check.passed for check in record.checks] == [False]
    whole, _ = run_case(Case(scene, "ghostball", truth_of(scene), graded))
    assert [check.passed for check in whole.checks] == [True]


def test_what_is_graded_up_to_the_horizon_only_leaves_the_end_open():
    scene = find_scene("chaos-a")
    record, _ = run_case(
        Case(scene, "ghostball", truth_of(scene), asked_of([("ghostball", {})], Criteria()))
    )
    assert record.horizon is not None
    assert all(check.passed for check in record.checks)
    assert verdict_of(record) is Verdict.LIMITS_HOLD


def test_what_is_round_scatters_a_ball_as_another_ball_does():
    # The width is half the mean radius of ball and obstacle: (0.03 + 0.2) / 2 = 0.115 m.
    post = {"centre": (0.5, 0.25), "radius": 0.2}
    cue = Ball(id="a", position=(0.1, 0.3), velocity=(1.0, 0.0), radius=0.03)
    table = Table.model_validate({"length": 1.0, "width": 0.5, "posts": [post]})
    scene = Scene(name="post", balls=[cue], table=table, physics=Physics(preset="paper"), t_max=0.5)
    run = simulate(scene, record="trajectory")
    meetings = meetings_of(RunGrowth(run), run)
    assert len(meetings.times) == 1
    (size,) = RunGrowth(run).sizes(np.nextafter(meetings.times, 0.0))[0]
    assert meetings.largest[0] == pytest.approx(size * 0.03 / 0.115, rel=1e-9)


@pytest.mark.parametrize("name", ["pocket-rattle", "pocket-side", "pocket-bank", "flight-jump"])
def test_a_centimetre_is_too_much_for_jaws_pockets_and_flights(name):
    assert truth_of(find_scene(name)).horizon_of(1e-2) < math.inf
