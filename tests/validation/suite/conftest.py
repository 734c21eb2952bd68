"""A fixture that installs faulty engines for tests of the suite."""

from __future__ import annotations

import pytest
from faulty_engine import Absent, Fake, planted


@pytest.fixture
def fake_engines(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """Install the fake engines as a package with entry points, which worker processes also find."""
    site = planted(tmp_path_factory.mktemp("site"), Fake, Absent)
    monkeypatch.syspath_prepend(str(site))
