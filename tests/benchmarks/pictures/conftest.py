"""Results folders for tests of pictures."""

from pathlib import Path

import pytest
from written_results import LABELS, SHOTS, write_results


@pytest.fixture(scope="session")
def results_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Nine scenes on seven engines; no test writes into the folder."""
    return write_results(tmp_path_factory.mktemp("results"), list(SHOTS), LABELS)


@pytest.fixture
def small_folder(tmp_path: Path) -> Path:
    """One scene on three engines, for tests that write into the folder."""
    return write_results(tmp_path / "small", ["stop"], LABELS[:3])
