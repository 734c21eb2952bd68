"""The causes of differences, for engines with planted errors of model, time step and rounding."""

from dataclasses import replace

import numpy as np
import pytest
from toy_engines import ToyEngine, ToySettings, cut, other_shot, roll

from ghostball.model import Ball, EventKind, Scene, Status, Table, UnsupportedSceneError
from ghostball.reference_adapters import make_engine
from ghostball.validation import find_scene
from ghostball.validation.diagnose.attribution import agreed_instant, attribute
from ghostball.validation.grading.event_logs import Event
from ghostball.validation.truth.known_shot import known_shot

THREE = {"a": (1.2, 0.6), "b": (1.35, 0.65), "c": (1.3, 0.75)}


def toy(**settings):
    return ToyEngine(ToySettings(**settings))


@pytest.mark.parametrize("order", [0.75, 1.0, 2.0, 4.0])
def test_what_goes_away_with_the_step_is_the_steps(order):
    slope = 4e-3 / 0.01**order
    found = attribute(roll(), toy(slope=slope, order=order, model=2e-4))
    assert found.outcome == "step"
    assert found.truth == "certified"
    assert found.difference == pytest.approx(np.hypot(4e-3, 2e-4), rel=1e-9)
    assert [one.step for one in found.ladder] == [0.01, 0.0025, 0.000625]
    assert found.ladder[1].difference == pytest.approx(np.hypot(4e-3 / 4.0**order, 2e-4), rel=1e-9)
    assert found.instant is None
    assert found.rounding < 1e-10


@pytest.mark.parametrize("step", [{}, {"slope": 0.1}, {"wobble": 1e-3}])
def test_what_stays_whatever_the_step_is_the_models(step):
    found = attribute(roll(), toy(model=5e-3, **step))
    assert found.outcome == "model"
    assert found.ladder[-1].difference == pytest.approx(5e-3, rel=0.03)


def test_errors_that_do_not_fall_are_no_steps():
    found = attribute(roll(), toy(wobble=1e-3))
    assert found.outcome == "model"
    assert [one.difference for one in found.ladder] == pytest.approx([1e-3] * 3)


@pytest.mark.parametrize("dt", [0.011, 0.013, 0.017, 0.019])
def test_a_sawtooth_in_the_phase_of_the_steps_is_the_steps(dt):
    assert attribute(roll(), toy(sawtooth=0.5, dt=dt)).outcome == "step"


def test_an_engine_without_errors_differs_by_rounding():
    found = attribute(roll(), toy())
    assert found.outcome == "rounding"
    assert found.difference <= found.rounding


def test_pymunk_is_blamed_for_its_step_where_it_has_no_model_error():
    """In these scenes, the error of pymunk is micrometres if the time step is suitable."""
    balls = [
        Ball(id="cue", position=(0.5, 0.4), velocity=(1.8, 0.525)),
        *(Ball(id=name, position=place) for name, place in THREE.items()),
    ]
    shot = Scene(name="typed", table=Table(length=2.54, width=1.27), balls=balls)
    found = attribute(shot, make_engine("pymunk"))
    assert found.outcome == "step"
    assert found.with_exact_steps < 1e-3 * found.difference


def test_what_plays_it_better_is_measured():
    scene = find_scene("half-ball-cut")
    found = attribute(scene, make_engine("pymunk"))
    finest = found.ladder[-1]
    assert found.with_exact_steps < finest.difference < found.difference
    again = make_engine(f"pymunk:dt={finest.step!r}").simulate(scene)
    off = again.rest_positions - known_shot(scene).rest_positions
    assert np.linalg.norm(off, axis=1).max() == pytest.approx(finest.difference, rel=1e-9)


def test_of_an_engine_without_a_step_all_is_its_model():
    found = attribute(roll(), other_shot(speed=0.01))
    assert (found.outcome, found.ladder) == ("model", ())
    assert found.difference > 1e-3


def test_a_roll_that_ends_half_a_step_short():
    # With semi-implicit Euler, a roll ends v dt / 2 too short.
    found = attribute(find_scene("stop"), make_engine("paper-discrete"))
    assert found.outcome == "step"
    assert [one.difference for one in found.ladder] == pytest.approx(
        [0.8 * 0.02 / 2.0 / 4.0**k for k in range(3)], rel=0.1
    )
    assert any("semi-implicit" in text for text in found.approximations)


@pytest.mark.parametrize("label", ["paper-discrete", "pymunk"])
def test_runs_with_wrong_collisions_are_compared_by_the_times_of_those_they_share(label):
    """Fails if differences of femtometres before the first collision are called "rounding"."""
    found = attribute(find_scene("break-7"), make_engine(label))
    assert found.outcome == "step"
    assert found.difference is None
    assert found.shared == 4
    assert found.late == found.ladder[0].late > 1e-3
    assert found.ladder[-1].late < 0.1 * found.late
    assert found.instant == min(one.wrong_from for one in found.ladder if one.wrong_from)
    assert "collisions differ" in found.until


def lucky(fourth):
    """Return an engine whose second run is right by luck, so that its third run seems worse.

    `fourth` maps a right run with a still shorter step to the returned run.
    """

    class Lucky(ToyEngine):
        def simulate(self, scene, *, record="rest"):
            errors = {0.01: 1e-3, 0.0025: 1e-4, 0.000625: 6e-4}
            dt = self.settings.dt
            result = toy(model=errors.get(dt, 1e-5), dt=dt).simulate(scene, record=record)
            return result if dt in errors else fourth(result)

    return Lucky()


def test_a_ladder_that_contradicts_itself_gets_another_rung():
    found = attribute(roll(), lucky(lambda right: right))
    assert found.outcome == "step"
    assert len(found.ladder) == 4


def test_a_fourth_run_that_stops_early_is_not_compared():
    stopped = {"status": Status.STEP_LIMIT, "reason": "too many steps"}
    found = attribute(roll(), lucky(lambda right: replace(right, **stopped)))
    assert found.outcome == "not compared"
    assert "too many steps" in found.reason


@pytest.mark.parametrize("predictable", [np.inf, 0.6])
def test_a_fourth_run_with_wrong_collisions_is_compared_by_times(predictable, monkeypatch):
    # Balls that miss each other rest far from their reference positions; this doesn't prove a wrong
    # model.
    def misses(right):
        missed = other_shot(turn=0.5).simulate(right.scene, record="events")
        return replace(missed, engine="toy", settings=right.settings)

    where = "ghostball.validation.diagnose.attribution.horizon"
    monkeypatch.setattr(where, lambda *_: predictable)
    found = attribute(cut(), lucky(misses))
    assert (found.outcome, found.shared) == ("unseparated", 0)
    assert [one.wrong_from is None for one in found.ladder] == [True, True, True, False]
    assert found.instant == found.ladder[-1].wrong_from


def test_nothing_is_compared_past_what_can_be_predicted():
    found = attribute(find_scene("chaos-a"), make_engine("ghostball"))
    assert found.instant is not None
    assert "rounding moves a ball" in found.until
    assert found.outcome == "agrees"
    assert found.rounding < 1e-5


def test_a_run_that_stops_early_is_not_compared():
    found = attribute(roll(), make_engine("pymunk:max_time=0.5"))
    assert found.outcome == "not compared"
    assert "`max_time`" in found.reason


def test_a_scene_that_the_engine_lacks_is_refused():
    with pytest.raises(UnsupportedSceneError):
        attribute(find_scene("sliding-stun"), make_engine("paper-discrete"))


def test_the_same_twice():
    once, again = (attribute(cut(), toy(slope=0.4)) for _ in range(2))
    assert once == again


# --- the instant of comparison

TRUE = [Event(EventKind.BALL_BALL, 0, 1, 1.0), Event(EventKind.BALL_BALL, 1, 2, 2.0)]


def late(by):
    return [replace(one, t=one.t + by) for one in TRUE]


def test_runs_that_agree_are_compared_at_the_end_of_what_can_be_predicted():
    assert agreed_instant(TRUE, [late(0.1), late(0.2)], np.inf) is None
    assert agreed_instant(TRUE, [late(0.1), late(0.2)], 3.0) == 3.0
    assert agreed_instant(TRUE, [late(0.1), late(0.2)], 2.1) == pytest.approx(0.5 * (1.2 + 2.0))


def test_runs_that_part_are_compared_amid_the_time_before():
    assert agreed_instant(TRUE, [late(0.1), late(0.2)[:1]], np.inf) == pytest.approx(1.6)
    assert agreed_instant(TRUE, [late(0.1)[1:]], np.inf) == pytest.approx(0.5)
