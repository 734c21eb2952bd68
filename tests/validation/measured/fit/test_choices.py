"""The fields that a fit can determine for an engine, and the choice among solutions by misfit."""

from __future__ import annotations

import numpy as np
import pytest

from ghostball.model import Physics
from ghostball.reference_adapters import make_engine
from ghostball.validation.measured.fit.choices import mean_of
from ghostball.validation.measured.fit.fields import FIELDS, cushion_laws, lacking, own_fields
from ghostball.validation.measured.fit.least_squares import Solution


def solution(value, misfit, error=0.1):
    """Return a solution with one value and a given misfit."""
    left = np.ones((10, 1))
    return Solution(np.array([value]), np.array([[error**2]]), left, [], 11, misfit, True)


def test_solutions_that_fit_alike_are_weighed_by_what_is_assumed():
    tried = {spreads: solution(1.0 + spreads, 50.0) for spreads in range(-4, 5)}
    mean, there, best = mean_of(tried)
    assert mean.values[0] == pytest.approx(1.0)
    assert (there, best) == (pytest.approx(0.0), 0)
    # The value changes by 1 per standard deviation of the assumption, which adds 1 to the variance
    # of the fits. The distance of the tried assumptions adds 1/12.
    assert mean.covariance[0, 0] == pytest.approx(1.0 + 0.1**2 + 1.0 / 12.0, rel=1e-3)


def test_a_side_that_fits_badly_does_not_count():
    """The misfit rises on one side only, so the mean differs from the best fit."""
    tried = {
        spreads: solution(1.0 + spreads, 50.0 + 99.0 * (spreads < 0)) for spreads in (-1, 0, 1)
    }
    mean, there, best = mean_of(tried)
    share = np.exp(-0.5) / (1.0 + np.exp(-0.5))
    assert mean.values[0] == pytest.approx(1.0 + share)
    assert (there, best) == (pytest.approx(share), 0)
    assert mean.covariance[0, 0] == pytest.approx(share * (1.0 - share) + 0.1**2 + 1.0 / 12.0)


def test_a_single_solution_is_its_own_mean():
    mean, there, best = mean_of({2: solution(1.0, 50.0)})
    assert (mean.values[0], mean.errors[0]) == pytest.approx((1.0, 0.1))
    assert (there, best) == (2.0, 2)


def test_fields_are_those_of_physics():
    assert set(FIELDS) <= set(Physics.model_fields)


def test_an_engine_that_has_all_of_a_preset_lacks_nothing():
    assert lacking(make_engine("ghostball"), "pool") == {}


def test_what_an_engine_lacks_is_held_where_it_has_it():
    engine = make_engine("pybullet")
    held = lacking(engine, "pool")
    assert held["rolling_friction_quadratic"] == held["cushion_restitution_loss"] == 0.0
    assert held["cushion"] in [law.name for law in cushion_laws(engine)]


@pytest.mark.parametrize(
    ("law", "names"),
    [
        ("restitution", {"cushion_restitution", "cushion_restitution_loss"}),
        (
            "han2005",
            {
                "cushion_restitution",
                "cushion_restitution_loss",
                "cushion_friction",
                "cushion_height",
            },
        ),
    ],
)
def test_a_law_has_the_fields_that_it_uses_and_contacts_alone_tell(law, names):
    (entry,) = (one for one in cushion_laws(make_engine("ghostball")) if one.name == law)
    assert {one.name for one in own_fields(entry, list(FIELDS.values()))} == names
