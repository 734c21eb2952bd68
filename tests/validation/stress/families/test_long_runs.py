"""Long runs: the numbers they are held against are right, and a wrong one is seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import SampledTrajectory, UnsupportedSceneError
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.stress.families.long_runs import GalperinTrial, GasTrial, _Seen, galperin
from ghostball.validation.stress.gas import gas


def test_the_collisions_of_galperin_are_the_digits_of_pi():
    digits = "31415926535"
    assert [str(galperin(k)[0]) for k in range(9)] == [digits[: k + 1] for k in range(9)]


@pytest.mark.parametrize("digits", [0, 1, 2])
def test_galperin_is_counted_and_a_lost_collision_is_seen(digits, monkeypatch):
    trial = GalperinTrial("galperin", digits, True)
    assert trial.run(make_engine("ghostball")).faults == ()
    right = galperin(digits)
    monkeypatch.setattr(
        "ghostball.validation.stress.families.long_runs.galperin",
        lambda _: (right[0] + 1, *right[1:]),
    )
    assert "instead of" in trial.run(make_engine("ghostball")).faults[0]


@pytest.mark.parametrize(
    ("engine", "passes", "breaks"), [("pymunk", 1e-7, 1e-5), ("ghostball", 1e-16, 1e-14)]
)
def test_speeds_of_galperin_that_are_off_are_seen(engine, passes, breaks, monkeypatch):
    """By the noise of a solver, in an engine that steps; by rounding, in ours."""
    count, light, heavy = galperin(0)
    for off, seen in ((passes, False), (breaks, True)):
        wrong = (count, light + off, heavy)
        monkeypatch.setattr(
            "ghostball.validation.stress.families.long_runs.galperin", lambda _, it=wrong: it
        )
        faults = GalperinTrial("galperin", 0, True).run(make_engine(engine)).faults
        assert any("end speeds" in fault for fault in faults) == seen


def test_steps_are_asked_for_few_collisions():
    with pytest.raises(UnsupportedSceneError, match="31415 collisions"):
        GalperinTrial("galperin", 4, False).run(make_engine("paper-discrete"))


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


def test_an_engine_that_steps_is_asked_by_the_law_alone_how_energy_drifts():
    scene = gas(4, 0.3, 1.0)
    result = simulate(scene, record="trajectory")
    times = np.linspace(0.0, result.rest_time, 101)
    frames = SampledTrajectory(times, *result.sample(times))
    end = result.final_state._replace(velocities=1.1 * result.final_state.velocities)
    seen = _Seen(scene)
    seen.add(replace(result, trajectory=frames, final_state=end, settings={"dt": 1e-4}))
    assert seen.verdict().faults == ()
    way = 1e-4 * np.max(np.linalg.norm(scene.velocities, axis=1))
    assert seen.slack == pytest.approx(way)
    assert "overlap" in replace(seen, deepest=1.01 * seen.slack).verdict().faults[0]
