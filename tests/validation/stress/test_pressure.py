"""The pressure of hard discs: one that is off, and speeds that are, are seen."""

from __future__ import annotations

import numpy as np
import pytest

from ghostball.engine import UnsupportedSceneError, simulate
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.stress.gas import gas, literature
from ghostball.validation.stress.pressure import PressureTrial, judge_pressure, middle_of


def test_steps_are_asked_for_few_collisions():
    with pytest.raises(UnsupportedSceneError, match="too many"):
        PressureTrial("p", 0.3, 32, 1000, 16, 0).run(make_engine("paper-discrete"))


def test_a_pressure_that_is_off_and_one_that_is_unsure_are_seen():
    """Blocks made of the literature's own numbers, with a scatter of 0.1 %."""
    packing, scene = 0.3, gas(16, 0.3, 1.0)
    area = (scene.table.length - 20.0 * scene.radii[0]) ** 2
    discs = packing * area / (np.pi * scene.radii[0] ** 2)
    hits = discs * (literature(packing)[0] - 1.0) / scene.radii[0] / np.sqrt(np.pi)
    one, other = 1.0 + 1e-3 * np.random.default_rng(1).standard_normal((2, 20))
    mean = np.sqrt(np.pi)  # of the speeds of approach, at k T = 1 J
    parts = np.array(
        [[discs, 1.0, hits * x, hits * x * y * mean, 1.0] for x, y in zip(one, other, strict=True)]
    )
    fine = judge_pressure(scene, parts, 0.005, speeds=True)
    assert fine.faults == ()
    assert fine.values["approach_speed"] == pytest.approx(1.0, abs=1e-3)
    dense = judge_pressure(scene, parts * [1, 1, 1.01, 1.01, 1], 0.005, speeds=True)
    (fault,) = dense.faults
    assert "p/nkT" in fault
    (fault,) = judge_pressure(scene, parts, 1e-6, speeds=True).faults
    assert "the error is" in fault
    (fault,) = judge_pressure(scene, parts * [1, 1, 1, 1.01, 1], 0.005, speeds=True).faults
    assert "approach at 1.01" in fault
    # Of engines that step no speed at an instant is known.
    blind = judge_pressure(scene, parts * [1, 1, 1, 1.01, 1], 0.005, speeds=False)
    assert (blind.faults, blind.values["approach_speed"]) == ((), None)


def test_the_middle_holds_its_share_of_the_discs():
    discs, seconds, *_ = middle_of(simulate(gas(16, 0.3, 0.1), record="trajectory"), 0.0, 0.1)
    side = gas(16, 0.3, 0.1).table.length
    share = ((side - 20.0 * 0.028575) / side) ** 2
    assert discs / seconds == pytest.approx(256 * share, rel=0.15)
