"""Results folders for tests of reports."""

from pathlib import Path

import numpy as np
import pytest
from page_texts import page_of
from written_results import LABELS, SHOTS, write_results

from ghostball.model import EVENT_DTYPE, Result, SampledTrajectory, Status, initial_state
from ghostball.reports.shots import load_shot
from ghostball.validation.results.store import Results


@pytest.fixture(scope="session")
def results_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Nine scenes on seven engines; no test writes into the folder."""
    return write_results(tmp_path_factory.mktemp("results"), list(SHOTS), LABELS)


@pytest.fixture(scope="session")
def results(results_folder: Path) -> Results:
    """Nine scenes on seven engines."""
    return Results.open(results_folder)


@pytest.fixture(scope="session")
def three_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three scenes on all engines, for tests that write into the folder."""
    return write_results(tmp_path_factory.mktemp("three"), ["stop", "head-on", "break-7"], LABELS)


@pytest.fixture(scope="session")
def html(three_folder: Path) -> str:
    """A whole page: some cases pass, some fail, one crashed, one is unsupported."""
    return page_of(three_folder)


@pytest.fixture
def small_folder(tmp_path: Path) -> Path:
    """One scene on three engines, for tests that write into the folder."""
    return write_results(tmp_path / "small", ["stop"], LABELS[:3])


@pytest.fixture
def result(results):
    """A result, as an engine returns it."""
    shot = load_shot(results, "head-on")
    motion, state = shot.ours.motion, initial_state(shot.scene)
    return Result(
        engine="ghostball",
        settings={},
        scene=shot.scene,
        status=Status.REST,
        final_state=state,
        rest_time=3.0,
        collision_counts={"ball-ball": 1, "ball-cushion": 0},
        work={},
        wall_time=0.0,
        events=np.array([(1.0, 0, 0, 1)], dtype=EVENT_DTYPE),
        trajectory=SampledTrajectory(
            motion.times, motion.positions, motion.velocities, motion.angular_velocities
        ),
    )
