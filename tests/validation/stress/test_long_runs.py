"""Long runs: the numbers they are held against are right, and a wrong one is seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from engine import UnsupportedSceneError, simulate
from reference_adapters.registry import make_engine
from validation.stress.families.long_runs import (
    FAMILY,
    GalperinTrial,
    GasTrial,
    PressureTrial,
    _Seen,
    galperin,
    judge_pressure,
    middle_of,
)
from validation.stress.gas import (
    begun_at_end,
    collision_rate,
    gas,
    literature,
    patient,
    stray_momentum,
)


@pytest.mark.parametrize("suite", ["quick", "full"])
def test_names_are_unique(suite):
    names = [trial.name for trial in FAMILY.trials(suite)]
    assert len(names) == len(set(names))


def test_the_collisions_of_galperin_are_the_digits_of_pi():
    digits = "31415926535"
    assert [str(galperin(k)[0]) for k in range(9)] == [digits[: k + 1] for k in range(9)]


@pytest.mark.parametrize("digits", [0, 1, 2])
def test_galperin_is_counted_and_a_lost_collision_is_seen(digits, monkeypatch):
    trial = GalperinTrial("galperin", digits, True)
    assert trial.run(make_engine("ghostball")).faults == ()
    right = galperin(digits)
    monkeypatch.setattr(
        "validation.stress.families.long_runs.galperin", lambda _: (right[0] + 1, *right[1:])
    )
    assert "instead of" in trial.run(make_engine("ghostball")).faults[0]


def test_steps_are_asked_for_few_collisions():
    with pytest.raises(UnsupportedSceneError, match="31415 collisions"):
        GalperinTrial("galperin", 4, False).run(make_engine("paper-discrete"))
    with pytest.raises(UnsupportedSceneError, match="too many"):
        PressureTrial("p", 0.3, 32, 1000, 16, 0).run(make_engine("paper-discrete"))


def test_a_gas_survives_and_its_drift_overlap_and_stray_momentum_are_seen():
    assert GasTrial("gas", 4, 0.3, 300, 100).run(make_engine("ghostball")).faults == ()
    scene = gas(4, 0.3, 1.0)
    result = simulate(scene, record="trajectory")
    seen = _Seen(scene)
    seen.add(result)
    assert seen.verdict().faults == ()
    assert "drifts" in replace(seen, energy=seen.energy * (1 + 1e-12)).verdict().faults[0]
    assert "overlap" in replace(seen, deepest=1e-12).verdict().faults[0]
    assert "from nowhere" in replace(seen, stray=[(1e-10, 0.0)]).verdict().faults[0]


def test_momentum_that_one_collision_loses_is_found():
    result = simulate(gas(4, 0.3, 1.0), record="trajectory")
    stray = stray_momentum(result)
    assert stray is not None
    assert max(map(abs, stray)) < 1e-13
    result.trajectory.knots[3][5:, 3] += 1e-9
    stray = stray_momentum(result)
    assert stray is not None
    assert abs(stray[0]) > 1e-10


def test_a_run_cut_in_two_is_the_run():
    whole = simulate(gas(3, 0.2, 0.5))
    half = simulate(gas(3, 0.2, 0.25))
    rest = simulate(begun_at_end(half, 0.25))
    assert np.allclose(rest.rest_positions, whole.rest_positions, atol=1e-12)


def test_the_literature_is_a_known_equation_of_state():
    """Henderson 1975 is within a part in 200 up to 0.5, and the series of low density exact."""
    for x in (0.01, 0.1, 0.3, 0.5):
        assert literature(x)[0] == pytest.approx((1 + x**2 / 8) / (1 - x) ** 2, rel=5e-3)
    assert literature(1e-4)[0] == pytest.approx(1.0 + 2e-4 + 0.7820044 * 4e-8, abs=1e-11)
    assert literature(0.6)[1] < 0.005 * literature(0.6)[0]


def test_a_pressure_that_is_off_and_one_that_is_unsure_are_seen():
    """Blocks made of the literature's own numbers, with a scatter of 0.1 %."""
    packing, scene = 0.3, gas(16, 0.3, 1.0)
    area = (scene.table.length - 20.0 * scene.radii[0]) ** 2
    discs = packing * area / (np.pi * scene.radii[0] ** 2)
    hits = discs * (literature(packing)[0] - 1.0) / scene.radii[0] / np.sqrt(np.pi)
    noise = 1.0 + 1e-3 * np.random.default_rng(1).standard_normal(20)
    parts = np.array([[discs, 1.0, hits * x, hits * x, 1.0] for x in noise])
    assert judge_pressure(scene, parts, 0.005).faults == ()
    assert "standard errors" in judge_pressure(scene, parts * [1, 1, 1.01, 1, 1], 0.005).faults[0]
    assert "the error is" in judge_pressure(scene, parts, 1e-6).faults[0]


@pytest.mark.slow
@pytest.mark.compiled
def test_the_rate_of_collisions_is_the_theory_s():
    result = simulate(gas(16, 0.3, 2.0))
    expected = 2.0 * collision_rate(256, 0.3)
    assert result.collision_counts["ball-ball"] == pytest.approx(expected, rel=0.15)


def test_the_middle_holds_its_share_of_the_discs():
    discs, seconds, *_ = middle_of(simulate(gas(16, 0.3, 0.1), record="trajectory"), 0.0, 0.1)
    side = gas(16, 0.3, 0.1).table.length
    share = ((side - 20.0 * 0.028575) / side) ** 2
    assert discs / seconds == pytest.approx(256 * share, rel=0.15)


def test_patience_is_for_our_engine_only():
    ours, other = make_engine("ghostball"), make_engine("paper-discrete")
    assert patient(ours, 10**9).settings.max_events == 10**9
    assert patient(ours, 10) is ours
    assert patient(other, 10**9) is other
