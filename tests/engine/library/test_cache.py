"""Tests of the folder of libraries: old libraries are removed, and nothing else."""

import os
import time

import pytest

from ghostball.engine.library import cache
from ghostball.engine.library.cache import KEPT, UNUSED
from ghostball.model.cache_folder import note_use


@pytest.fixture
def folder(monkeypatch, tmp_path):
    monkeypatch.setenv("GHOSTBALL_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(cache, "directory", cache.directory.__wrapped__)
    return cache.directory()


def library(folder, name, age=0.0):
    """Make a library that was last used `age` seconds ago."""
    path = folder / name
    path.write_bytes(b"code")
    used = time.time() - age  # the present time: tests may be collected long before they run
    os.utime(path, (used, used))
    return path


def test_old_libraries_are_removed_and_those_used_last_kept(folder):
    made = [
        library(folder, f"play-{age:020x}.{'so' if age % 2 else 'o'}", (age + 2) * UNUSED)
        for age in range(KEPT + 4)
    ]
    cache.prune(folder)
    assert [path.exists() for path in made] == [True] * KEPT + [False] * 4


def test_what_was_used_within_a_day_stays(folder):
    made = [library(folder, f"play-{age:020x}.so", age) for age in range(KEPT + 4)]
    cache.prune(folder)
    assert all(path.exists() for path in made)


def test_use_makes_a_library_young(folder):
    one = library(folder, f"play-{0:020x}.so", 9.0 * UNUSED)
    note_use(one)
    assert one.stat().st_mtime > time.time() - UNUSED
    note_use(folder / "gone.so")  # removed by another process; this one may have loaded it


def test_what_is_not_ours_is_never_removed(folder, tmp_path):
    old = 1000.0 * UNUSED
    for age in range(KEPT):
        library(folder, f"play-{age:020x}.so")
    theirs = [library(folder, name, old) for name in ("thesis.so", "play-12.so", "play-X.so")]
    target = library(tmp_path, "elsewhere", old)
    link = folder / f"play-{KEPT + 1:020x}.so"
    link.symlink_to(target)
    cache.prune(folder)
    assert all(path.exists() for path in (*theirs, target, link))


def test_nothing_is_removed_where_our_marker_is_missing(folder):
    made = [library(folder, f"play-{age:020x}.so", 9.0 * UNUSED) for age in range(KEPT + 2)]
    (folder / "CACHEDIR.TAG").write_text("Signature: 8a477f597d28d172789f06886806bc55\n")
    cache.prune(folder)
    assert all(path.exists() for path in made)


def test_a_library_that_another_process_makes_is_kept(folder):
    made = [library(folder, f"play-{age:020x}.so", 9.0 * UNUSED + age) for age in range(KEPT + 1)]
    with cache.alone(made[-1]):
        cache.prune(folder)
        assert made[-1].exists()
    cache.prune(folder)
    assert not made[-1].exists()


def test_an_unwritable_folder_is_reported(monkeypatch, tmp_path, caplog):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("GHOSTBALL_CACHE_DIR", str(tmp_path / "file"))
    monkeypatch.setattr(cache, "directory", cache.directory.__wrapped__)
    assert cache.directory() is None
    assert "can't be kept" in caplog.text
    assert "GHOSTBALL_CACHE_DIR" in caplog.text
