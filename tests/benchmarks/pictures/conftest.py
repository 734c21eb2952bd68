"""Results folders to draw pictures of."""

from pathlib import Path

import pytest
from written_results import LABELS, SHOTS, write_results


@pytest.fixture(scope="session")
def results_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Nine scenes on seven engines; nobody writes into it."""
    return write_results(tmp_path_factory.mktemp("results"), list(SHOTS), LABELS)


@pytest.fixture
def small_folder(tmp_path: Path) -> Path:
    """One scene on three engines, to write a report into."""
    return write_results(tmp_path / "small", ["stop"], LABELS[:3])
