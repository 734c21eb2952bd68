"""Installs the engines that misbehave, for the tests of the suite that ask for them."""

from __future__ import annotations

import pytest
from faulty_engine import Absent, Fake, planted


@pytest.fixture
def fake_engines(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """Install the fakes as anyone's package would be: worker processes must find them too."""
    site = planted(tmp_path_factory.mktemp("site"), Fake, Absent)
    monkeypatch.syspath_prepend(str(site))
