"""Installs the engines that misbehave, for the tests of the suite that ask for them."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from suite_runs import ENGINES, ENTRY_POINTS


@pytest.fixture
def fake_engines(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Install the fakes as anyone's package would be: worker processes must find them too."""
    site = tmp_path_factory.mktemp("site")
    (site / "fake_engines.py").write_text(ENGINES)
    package = site / "fake_engines-1.0.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: fake-engines\nVersion: 1.0\n")
    (package / "entry_points.txt").write_text(ENTRY_POINTS)
    monkeypatch.syspath_prepend(str(site))
    monkeypatch.delitem(sys.modules, "fake_engines", raising=False)
    return site
