"""Store the certificates of each test in a separate folder, so that each test computes its own."""

import pytest

from ghostball.reference_adapters.certified import cache


@pytest.fixture(autouse=True)
def kept_here(monkeypatch, tmp_path):
    # Not by the environment variable, which would also move the engine's compiled kernels.
    monkeypatch.setattr(cache, "directory", lambda: tmp_path)
    return tmp_path
