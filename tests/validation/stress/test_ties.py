"""Ties: the closed forms are right, and impacts that come out otherwise are seen."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.stress.ties import Velocities, ties
from ghostball.validation.stress.trial import SceneTrial

OURS = make_engine("ghostball")


def trials() -> dict[str, SceneTrial]:
    return {one.name: one for one in ties("quick") if isinstance(one, SceneTrial)}


def test_impacts_at_one_instant_come_out_as_their_closed_forms() -> None:
    assert len(trials()) == 8
    for tie in trials().values():
        assert tie.run(OURS).faults == (), tie.name


def test_the_expected_velocities_keep_momentum_and_lose_energy() -> None:
    for name, tie in trials().items():
        if not isinstance(tie.judge, Velocities):
            continue
        expected = np.array(tie.judge.velocities)
        assert np.allclose(expected.sum(axis=0), (1.0, 0.0), rtol=0.0, atol=1e-15), name
        energy = float(np.sum(expected**2))
        if name.endswith("-1"):
            assert math.isclose(energy, 1.0, rel_tol=1e-14), name
        else:
            assert energy < 1.0, name


@pytest.mark.parametrize(
    ("name", "other"),
    [
        ("tie-uneven-sequential-1", "tie-uneven-simultaneous-1"),
        ("tie-symmetric-simultaneous-0.5", "tie-symmetric-simultaneous-1"),
    ],
)
def test_another_resolution_of_a_tie_is_caught(name: str, other: str) -> None:
    found = trials()
    judge, wrong = found[name].judge, found[other].scene
    verdict = judge(simulate(wrong, record="trajectory"))
    assert verdict.faults
    assert "instead of" in verdict.faults[0]


def test_a_mirrored_tie_is_caught() -> None:
    tie = trials()["tie-symmetric-sequential-1"]
    swapped = replace(
        tie.judge,  # type: ignore[type-var]
        velocities=tuple((vx, -vy) for vx, vy in tie.judge.velocities),  # type: ignore[attr-defined]
    )
    assert tie.run(OURS).faults == ()
    assert replace(tie, judge=swapped).run(OURS).faults


def test_velocities_that_are_not_finite_are_caught() -> None:
    tie = next(iter(trials().values()))
    run = simulate(tie.scene, record="trajectory")
    velocities = np.full_like(run.final_state.velocities, np.nan)
    lost = replace(run, final_state=run.final_state._replace(velocities=velocities))
    assert tie.judge(lost).faults
