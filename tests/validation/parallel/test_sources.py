"""The code that runs here: every source is in its hash."""

from __future__ import annotations

from pathlib import Path

import ghostball.validation.parallel.sources
from ghostball.validation.parallel.sources import (
    OUR_PACKAGES,
    code_files,
    hash_sources,
    source_folders,
)

# What holds the packages: a checkout, or where a wheel is installed.
ROOT = Path(ghostball.validation.parallel.sources.__file__).parents[2]


def test_the_hash_of_sources_sees_every_change(tmp_path: Path) -> None:
    inner = tmp_path / "p" / "inner"
    inner.mkdir(parents=True)
    (tmp_path / "p" / "a.py").write_text("x = 1")
    (inner / "b.py").write_text("y = 1")
    folders = [tmp_path / "p"]
    hashes = [hash_sources(folders)]
    (tmp_path / "p" / "scene.toml").write_text("an input")
    (tmp_path / "p" / "__pycache__").mkdir()
    (tmp_path / "p" / "__pycache__" / "a.pyc").write_text("made of a.py")
    assert hash_sources(folders) == hashes[0]
    (inner / "b.py").write_text("y = 2")
    hashes.append(hash_sources(folders))
    (inner / "b.py").rename(tmp_path / "p" / "b.py")
    hashes.append(hash_sources(folders))
    (tmp_path / "p" / "c.py").write_text("")
    hashes.append(hash_sources(folders))
    (inner / "page.html").write_text("{{ text }}")
    hashes.append(hash_sources(folders))
    (tmp_path / "p" / "a.py").write_text("x = 1y")  # not distinguished by joined contents alone
    (tmp_path / "p" / "b.py").write_text(" = 2")
    hashes.append(hash_sources(folders))
    assert len(set(hashes)) == len(hashes)


def test_all_our_sources_are_hashed() -> None:
    hashed = {
        path.relative_to(ROOT).as_posix()
        for folder in source_folders()
        for path in code_files(folder)
        if path.is_relative_to(ROOT)
    }
    wanted = {
        path.relative_to(ROOT).as_posix()
        for p in OUR_PACKAGES
        for suffix in ("py", "mjs", "so")  # a wheel brings libraries of the kernels
        for path in (ROOT / p).rglob(f"*.{suffix}")
    }
    assert hashed == wanted
    assert "model/impact_laws.py" in hashed
