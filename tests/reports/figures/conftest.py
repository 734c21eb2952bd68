"""Results to draw figures of."""

from pathlib import Path

import pytest

from ghostball.validation.results.store import Results


@pytest.fixture(scope="session")
def results(results_folder: Path) -> Results:
    """Nine scenes on seven engines."""
    return Results.open(results_folder)
