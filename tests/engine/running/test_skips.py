"""Tests that skips are harmless: switching a skip off changes no bit."""

import re

import numpy as np
import pytest
from recorded import fingerprint
from same import CHECKS
from shots import POOL_TABLE, ball, rack, random_shot, scene_of

from ghostball.engine import simulate
from ghostball.engine.core.kernel import COMPILED
from ghostball.engine.running import skips
from ghostball.engine.running.skips import BUILT_IN, MOST_IN_MATRIX, Skip, explain_skips
from ghostball.model import GhostballError, Scene
from ghostball.validation.scenes.library import FOLDER
from ghostball.validation.scenes.random_scenes import random_scene

EXACT = [skip for skip in Skip if skip not in {Skip.ADVANCEMENT, *BUILT_IN}]


@pytest.mark.parametrize("seed", [0, 1])
def test_switching_all_exact_skips_off_changes_no_bit(seed):
    scene = random_shot(seed, 5, preset="pool" if seed % 3 else "paper")
    kept = simulate(scene, record="events")
    off = simulate(scene, no_skip=EXACT)
    assert fingerprint(off) == fingerprint(kept)


@pytest.mark.compiled
@pytest.mark.parametrize("name", ["galperin-3", "elastic-gas"])
def test_advancement_agrees_with_the_quadratic_to_rounding(name):
    """Only the start is compared: in an elastic gas an error doubles about every collision."""
    scene = Scene.load(FOLDER / f"{name}.toml")
    kept = simulate(scene, record="events").events
    off = simulate(scene, record="events", no_skip=["advancement"]).events
    assert kept[:20][["kind", "a", "b"]].tolist() == off[:20][["kind", "a", "b"]].tolist()
    assert np.abs(off["t"][:3] / kept["t"][:3] - 1.0).max() <= 4 * 2.0**-52
    np.testing.assert_allclose(off["t"][:20], kept["t"][:20], rtol=1e-12)


def test_far_cells_are_the_pairs_that_have_no_bound(monkeypatch):
    monkeypatch.setattr(skips, "MOST_PAIRED", 0)
    scene = scene_of(*rack(6, (1.5, 0.63), 1e-4), ball((0.6, 0.63), (3.0, 0.0)), table=POOL_TABLE)
    kept = simulate(scene, record="events")
    off = simulate(scene, record="events", no_skip=["far-cells"])
    assert kept.work["cell_moves"] > 0 == off.work["cell_moves"]
    assert off.work["bounds"] > kept.work["bounds"]
    assert fingerprint(off) == fingerprint(kept)


def test_without_the_skip_of_records_a_log_is_kept():
    scene = scene_of(ball((0.0, 0.0), (1.0, 0.0)))
    assert simulate(scene).events is None
    assert len(simulate(scene, no_skip=["records"]).events) == 1


def test_explained_skips_follow_from_the_scene():
    def used(scene, **how):
        return {use.skip.value for use in explain_skips(scene, **how) if use.used}

    lonely = scene_of(ball((0.0, 0.0), (1.0, 0.0)))
    always = {"air-and-flight", "records"}
    assert used(lonely) == {"cushions", *always}
    gas = scene_of(ball((0, 0), (1.0, 0.0)), ball((1.0, 0.0)), rolling_friction=0.0, t_max=2.0)
    assert used(gas) - used(lonely) == {"undisturbed", "receding", "out-of-reach", "advancement"}
    assert "records" not in used(gas, record="events")
    assert used(gas) - used(gas, no_skip=["advancement"]) == {"advancement"}
    pool = scene_of(ball((0.6, 0.6), (1.0, 0.0)), table=POOL_TABLE, preset="pool")
    assert used(pool) == always
    thick = scene_of(ball((0.6, 0.6), (1.0, 0.0)), air_drag=0.004)
    assert used(lonely) - used(thick) == {"air-and-flight"}
    flies = scene_of(ball((0.6, 0.6)), motion="sliding", airborne=True)
    assert used(lonely) - used(flies) == {"air-and-flight"}


@pytest.mark.parametrize(
    ("names", "problem"),
    [
        (["cushion"], "`no_skip` must name skips, got 'cushion'. Known skips: undisturbed, "),
        ("cushions", "`no_skip` must be a collection of names, got 'cushions'"),
        (3, "`no_skip` must be a collection of names, got 3"),
        (["receding", "cushions"], "`no_skip` can't switch off receding: without it the engine "),
    ],
)
def test_a_skip_that_cannot_be_switched_off_is_refused(names, problem):
    with pytest.raises(GhostballError, match=re.escape(problem)):
        simulate(scene_of(ball((0.0, 0.0), (1.0, 0.0))), no_skip=names)


def test_a_matrix_of_bounds_that_would_not_fit_is_refused():
    balls = [ball((0.1 * k, 0.0)) for k in range(MOST_IN_MATRIX + 1)]
    scene = scene_of(*balls)
    with pytest.raises(GhostballError, match=r"must not contain far-cells .* 0\.5 GB"):
        simulate(scene, no_skip=["far-cells"])


@pytest.mark.skipif(COMPILED, reason="compiled runs have the slow tests of random scenes")
@pytest.mark.parametrize(
    ("number", "having"),
    [
        (1, {"flight": "on-top"}),
        (3, {"flight": "low"}),
        (2, {"air": "yes"}),
        (4, {"air": "yes", "flight": "jump"}),
        (3, {"quadratic": "yes", "layout": "rack"}),
    ],
)
def test_cells_change_no_bit_in_air_and_in_flight_without_compilation(number, having):
    assert CHECKS["cells"](random_scene(number, count="few", **having)) is None


def test_unequal_balls_that_may_fly_but_stay_on_the_cloth_have_the_same_bits_in_cells():
    """Their line of centres isn't level: they touch at less than the sum of the radii."""
    assert CHECKS["cells"](random_scene(330)) is None
