"""Physics fitted to tracks: known values are found, and undetermined values are reported."""

from __future__ import annotations

from functools import partial

import pytest

from benchmarks.synthetic_tracks import EXAMPLE_PHYSICS, POOL, synthetic_tracks
from ghostball.model import GhostballError, UnsupportedSceneError
from ghostball.reference_adapters import make_engine
from ghostball.validation.measured.fit.clean_events import CleanEvents, find_clean_events
from ghostball.validation.measured.fit.fields import DEFAULT_FIELDS
from ghostball.validation.measured.fit.fit import NotEnoughError, fit_table
from ghostball.validation.measured.fit.least_squares import Assumed


@pytest.fixture(scope="module")
def found():
    return find_clean_events(synthetic_tracks(EXAMPLE_PHYSICS, 100, 12, noise=5e-4, side=0.2), POOL)


def fitted(found, engine="ghostball", **options):
    made = make_engine(engine)
    return fit_table(found, made, partial(made.simulate, record="trajectory"), **options)


@pytest.mark.slow
def test_known_values_come_out_and_the_law_is_told(found):
    # Without the height of the nose, two cushion laws fit equally well.
    fit = fitted(found, nose_height=EXAMPLE_PHYSICS.cushion_height)
    assert set(fit.errors) == set(DEFAULT_FIELDS)
    for name, error in fit.errors.items():
        assert getattr(fit.physics, name) == pytest.approx(
            getattr(EXAMPLE_PHYSICS, name), abs=3.5 * error
        )
    assert fit.physics.cushion == "han2005"
    assert min(fit.laws, key=fit.laws.get) == "han2005"
    assert fit.laws_alike == ["han2005"]
    assert 0.7 < fit.goodness < 1.3
    # The standard errors are small.
    assert fit.errors["rolling_friction"] < 2e-4
    assert fit.errors["cushion_friction"] < 0.02


def test_chosen_fields_alone_are_fitted_and_the_rest_is_the_preset_s(found):
    few = CleanEvents(found.rolling[:60], found.cushion, [], found.noise)
    fit = fitted(few, fields=["rolling_friction"])
    assert set(fit.errors) == {"rolling_friction"}
    assert fit.laws == {}
    assert fit.physics.cushion_restitution == 0.85
    assert 0.0088 < fit.physics.rolling_friction < 0.011  # the quadratic friction is 0


@pytest.mark.slow
def test_another_engine_is_fitted_without_what_it_lacks(found):
    few = CleanEvents(found.rolling[:10], found.cushion[:8], [], found.noise)
    # Long time steps, because a fit simulates a thousand shots.
    engine = "pybullet:dt=1e-2"
    fit = fitted(few, engine, fields=["rolling_friction", "cushion_restitution"])
    assert fit.laws.keys() <= {"frictional", "restitution"}
    assert fit.physics.rolling_friction_quadratic == 0.0
    # One value for all speeds lies between the values of slow and fast balls.
    assert 0.008 < fit.physics.rolling_friction < 0.02


def test_what_a_few_events_do_not_tell_is_said(found):
    few = CleanEvents(found.rolling[:60], found.cushion[:7], found.hit[:3], found.noise)
    fit = fitted(few)
    assert set(fit.errors) == {"rolling_friction", "rolling_friction_quadratic"}
    assert fit.not_told["ball_restitution"] == (
        "3 hits of a ball at rest are clean; at least 8 of a kind are needed"
    )
    assert "cushion_restitution" in fit.not_told


def test_no_events_are_an_error_that_counts_them(found):
    with pytest.raises(
        NotEnoughError,
        match=r"not enough data for a fit: 2 stretches of "
        r"rolling, 0",
    ):
        fitted(CleanEvents(found.rolling[:2], [], [], found.noise))


def test_a_field_that_was_asked_for_must_be_told(found):
    few = CleanEvents(found.rolling, [], [], found.noise)
    with pytest.raises(NotEnoughError, match="can't fit `ball_restitution`: 0 hits"):
        fitted(few, fields=["ball_restitution"])
    with pytest.raises(
        NotEnoughError, match="pybullet doesn't support cushions whose restitution falls"
    ):
        fitted(found, "pybullet", fields=["cushion_restitution_loss"])


def test_an_engine_that_mentions_few_features_is_refused_by_what_it_lacks(found):
    with pytest.raises(UnsupportedSceneError, match="no sliding that becomes rolling"):
        fitted(found, "ghostball.validation.examples.stepper:Stepper")


def test_a_law_is_held_where_no_field_of_cushions_is_fitted(found):
    few = CleanEvents(found.rolling[:20], [], [], found.noise)
    fit = fitted(few, fields=["rolling_friction"], law="frictional")
    assert fit.physics.cushion == "frictional"


def test_a_law_that_uses_no_such_field_is_refused(found):
    with pytest.raises(GhostballError, match='no law "frictional" that uses cushion_height'):
        fitted(found, fields=["cushion_height"], law="frictional")


def test_contacts_alone_tell_no_friction_of_the_cloth(found):
    alone = CleanEvents([], found.cushion[:20], [], found.noise)
    said = []
    fit = fitted(
        alone, law="han2005", progress=lambda done, planned, _: said.append((done, planned))
    )
    assert set(fit.errors) == {
        "cushion_restitution",
        "cushion_restitution_loss",
        "cushion_friction",
    }
    assert {"rolling_friction", "sliding_friction"} <= set(fit.not_told)
    # The assumed values may be wrong, which adds to the errors.
    assert set(fit.assumed) == {"rolling_friction", "sliding_friction", "cushion_height"}
    height = 0.01 * 2.0 * POOL.radius
    assert fit.assumed["cushion_height"] == Assumed(0.0357, height)
    # The fit of the contacts is repeated for several heights.
    assert 1 < max(done for done, _ in said) < said[0][1]


@pytest.mark.slow
def test_a_nose_that_was_measured_makes_the_error_smaller(found):
    few = CleanEvents(found.rolling[:20], found.cushion[:20], [], found.noise)
    known = fitted(few, law="han2005", nose_height=0.0357)
    assumed = fitted(few, law="han2005")
    assert "cushion_height" in set(assumed.assumed) - set(known.assumed)
    assert known.physics.cushion_height == 0.0357
    assert known.errors["cushion_restitution"] < 0.9 * assumed.errors["cushion_restitution"]


def test_few_shots_widen_the_error(found):
    few = CleanEvents(found.rolling[:12], [], [], found.noise)
    fit = fitted(few, fields=["rolling_friction"])
    assert fit.errors["rolling_friction"] > 1.05 * fit.solutions["rolling"].errors[0]


def test_progress_is_told(found):
    said = []
    few = CleanEvents(found.rolling[:40], [], [], found.noise)
    fitted(few, progress=lambda done, planned, last: said.append((done, planned, last)))
    assert said[0][:2] == (0, 1)
    assert said[0][2].startswith("rolling, 1")
