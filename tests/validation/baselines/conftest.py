"""Fixtures for the tests of the gate and of acceptance: folders of results and baselines."""

from __future__ import annotations

from dataclasses import replace

import gate
import pytest

import ghostball.reference_adapters.ghostball
import ghostball.validation.runs.engine_runs
from ghostball.engine import simulate
from ghostball.validation.baselines import gate as gate_module
from ghostball.validation.baselines.accept import accept
from ghostball.validation.baselines.gate import Gate, compare_results
from ghostball.validation.baselines.regression import Regression, load_regression, save_regressions
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.results.store import Results
from ghostball.validation.suite.suite import run_suite

SCENES = [gate.cut_shot(), gate.roll_shot()]


class Workshop:
    """A folder of results and a folder of baselines."""

    def __init__(self, place, monkeypatch):
        self.out, self.baselines = place / "out", place / "accepted"
        self.gate = Gate("ghostball", "ghostball", self.baselines)
        self._monkeypatch = monkeypatch

    def compare(self, *, scenes=SCENES, **options) -> Regression:
        """Run the scenes, compare the results with the baselines, and store the comparison."""
        ours = Criteria(truth="engine")  # nothing here needs a proof
        criteria = {scene.name: ours for scene in scenes}
        run_suite(scenes, ["ghostball"], self.out, criteria=criteria)
        options = {"whole": False, **options}
        found = compare_results(Results.open(self.out), self.gate, **options)
        save_regressions([found], self.out)
        return found

    def accept(self, reason="It is right.", **options):
        # A planted fault also fails limits, which most tests of acceptance aren't about.
        options = {"even_though_limits_fail": True, **options}
        return accept(self.out, reason, self.gate, **options)

    def plant(self, speeds):
        """Multiply the cue ball's speed in our engine by the factor of each named scene."""

        def planted(scene, **options):
            factor = speeds.get(scene.name, 1.0)
            cue, *others = scene.balls
            vx, vy, _ = cue.velocity
            moved = cue.model_copy(update={"velocity": (vx * factor, vy, 0.0)})
            if factor != 1.0:
                rolls = {"angular_velocity": (-vy / cue.radius, vx * factor / cue.radius, 0.0)}
                moved = moved.model_copy(update=rolls)
            result = simulate(scene.model_copy(update={"balls": (moved, *others)}), **options)
            return replace(result, scene=scene)

        for module in (
            ghostball.reference_adapters.ghostball,
            ghostball.validation.runs.engine_runs,
        ):
            self._monkeypatch.setattr(module, "simulate", planted)

    def contents(self):
        return {path.name: path.read_bytes() for path in self.baselines.glob("*")}

    @property
    def candidates(self):
        found = load_regression(self.out)
        return tuple(one.scene for one in found.scenes if one.can_be_accepted)


@pytest.fixture
def shop(tmp_path, monkeypatch, in_this_process):
    # The two scenes with many balls take a second each; other tests run them.
    monkeypatch.setattr(gate_module, "many_balls", lambda: ())
    return Workshop(tmp_path, monkeypatch)


@pytest.fixture
def accepted(shop):
    """A `Workshop` with accepted baselines."""
    shop.compare()
    shop.accept("The first.")
    return shop
