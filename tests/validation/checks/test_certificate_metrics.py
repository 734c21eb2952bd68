"""Metrics that compare a run with the certified motion of its shot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import Result, SampledTrajectory, Scene
from ghostball.reference_adapters.certified import CertifiedSettings
from ghostball.validation.checks.certificate_metrics import CERTIFICATE
from ghostball.validation.checks.metrics import measure
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.truth.scene_truth import truth_of

STOP = find_scene("stop")


def framed(row: int = 0, by: float = 0.0, velocity: float = 0.0) -> Result:
    """Return an exact run in 101 frames, with an error added to ball 0 in one frame."""
    run = simulate(STOP, record="trajectory")
    times = np.linspace(0.0, run.rest_time, 101)
    positions, velocities, spins = (part.copy() for part in run.sample(times))
    positions[row, 0, 1] += by
    velocities[row, 0, 1] += velocity
    return replace(run, trajectory=SampledTrajectory(times, positions, velocities, spins))


def test_a_ball_beside_its_way_is_seen_though_it_ends_in_its_place() -> None:
    true = truth_of(STOP)
    assert measure(framed(), true).values["path_factor"] <= 4.0
    # The rounding of a position on a table is about 2^-53 m.
    factor = measure(framed(50, by=1e-9), true).values["path_factor"]
    assert 1e-10 * 2.0**53 < factor < 1e-9 * 2.0**53


@pytest.mark.parametrize("part", ["velocities", "angular_velocities"])
@pytest.mark.parametrize("name", ["stop", "half-ball-cut", "draw-shot", "pocket-draw"])
def test_velocities_and_spins_of_the_other_sign_are_seen(name: str, part: str) -> None:
    """Fails if only positions and energies are compared, because both are right here."""
    shot = find_scene(name)
    run, true = simulate(shot, record="trajectory"), truth_of(shot)
    times = np.linspace(0.0, run.rest_time, 101)
    right = SampledTrajectory(times, *run.sample(times))
    turned = getattr(right, part).copy()
    turned[40:60] *= -1.0
    for motion, wrong in ((right, False), (replace(right, **{part: turned}), True)):
        measured = measure(replace(run, trajectory=motion), true, ["path_factor"])
        factor = measured.values["path_factor"]
        assert factor is not None
        assert (factor > 2.0**33) == wrong
        assert (factor > 4.0) == wrong


def test_an_energy_that_is_no_number_has_no_factor() -> None:
    measured = measure(framed(50, velocity=np.nan), truth_of(STOP), ["energy_difference_factor"])
    assert measured.values == {"energy_difference_factor": None}
    assert measured.incomplete == {"energy_difference_factor"}
    assert "not finite" in measured.notes["energy_difference_factor"]


def test_what_needs_the_whole_proof_has_no_value_with_a_part_of_it() -> None:
    shot = find_scene("half-ball-cut")
    true = truth_of(shot, settings=CertifiedSettings(max_events=1))
    measured = measure(
        simulate(shot, record="trajectory"), true, [*CERTIFICATE, "energy_difference_factor"]
    )
    whole = ("rest_time_factor", "path_factor", "energy_difference_factor")
    for name in whole:
        assert measured.values[name] is None, name
        assert "certified" in measured.notes[name], name
    assert measured.values["graded_events"] == 1
    assert measured.values["event_time_factor"] <= 128.0
    assert not measured.incomplete


def test_a_ball_that_nothing_moves_may_be_a_rounding_of_the_table_from_its_place() -> None:
    """Fails if the allowed rounding depends only on the distance from the table's corner."""
    idle = {"id": "idle", "position": (0.1, 0.1)}
    data = STOP.model_dump(exclude_unset=True) | {"name": "idle"}
    data["balls"] = (*STOP.model_dump(exclude_unset=True)["balls"], idle)
    shot = Scene.model_validate(data)
    run, true = simulate(shot, record="trajectory"), truth_of(shot)
    half = np.array([1.27, 0.635, 0.0])
    for scale, most in ((1.0, 8.0), (2.0**30, np.inf)):
        end = run.final_state
        off = scale * ((end.positions - half) + half - end.positions)
        assert off[0, 1].any()
        moved = replace(run, final_state=end._replace(positions=end.positions + off))
        factor = measure(moved, true, ["quality_factor"]).values["quality_factor"]
        assert factor is not None
        assert np.isfinite(factor)
        assert (factor <= 8.0) == (most == 8.0)
