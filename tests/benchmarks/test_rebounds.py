"""The search of an engine's best coefficients for measured rebounds."""

from __future__ import annotations

import pytest

from benchmarks.rebounds import best_rebounds
from ghostball.reference_adapters import make_engine


@pytest.mark.slow
def test_a_restitution_that_falls_comes_nearer_than_one_number():
    ours = make_engine("ghostball")
    falls, fixed = (best_rebounds(ours, "han2005", falls=f) for f in (True, False))
    assert {"cushion_restitution_loss"} == set(falls.coefficients) - set(fixed.coefficients)
    assert falls.typical < 2.0 < fixed.typical
    engine, law, values, typical, most = falls.row
    assert (engine, law) == ("ghostball", "han2005, falls")
    assert values.startswith("e = 0.9")
    assert float(typical) < float(most)


def test_a_law_that_leaves_spin_alone_has_no_friction_and_stays_far_off():
    best = best_rebounds(make_engine("ghostball"), "restitution", falls=False)
    assert best.coefficients == {"cushion_restitution": pytest.approx(1.0, abs=0.01)}
    assert best.typical > 20.0
