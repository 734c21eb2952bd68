"""The search of an engine's best coefficients: it finds those that made the numbers."""

from __future__ import annotations

from functools import partial

import pytest

from benchmarks.rebounds import START, best_rebounds, row_of
from ghostball.engine import simulate

PLAY = partial(simulate, record="trajectory")


def test_a_restitution_that_falls_comes_nearer_than_one_number():
    falls, fixed = (best_rebounds("ours", PLAY, "han2005", falls=f) for f in (True, False))
    assert list(falls.coefficients) == list(START)
    assert list(fixed.coefficients) == ["cushion_restitution", "cushion_friction"]
    assert falls.typical < 2.0 < fixed.typical
    engine, law, values, typical, most = row_of(falls)
    assert (engine, law) == ("ours", "han2005, falls")
    assert values.startswith("e = 0.9")
    assert float(typical) < float(most)


def test_a_law_that_leaves_spin_alone_has_no_friction_and_stays_far_off():
    best = best_rebounds("ours", PLAY, "restitution", falls=False)
    assert best.coefficients == {"cushion_restitution": pytest.approx(1.0, abs=0.01)}
    assert best.typical > 20.0
