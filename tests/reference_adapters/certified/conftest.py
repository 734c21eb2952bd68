"""Certificates of the tests are kept in a folder of their own: each test computes its own."""

import pytest

from ghostball.reference_adapters.certified import cache


@pytest.fixture(autouse=True)
def kept_here(monkeypatch, tmp_path):
    # Not by the environment variable: that would move the engine's compiled kernels, too.
    monkeypatch.setattr(cache, "directory", lambda: tmp_path)
    return tmp_path
