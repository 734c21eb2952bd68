"""Variants of the kernels are compiled side by side, once each."""

import os

import pytest
from pool_tasks import Part

from ghostball.model import GhostballError
from ghostball.validation.parallel import compiling
from ghostball.validation.scenes.library import find_scene

SCENES = [find_scene(name) for name in ("stop", "half-ball-cut", "mathavan-cut")]


@pytest.fixture
def parts(monkeypatch, tmp_path):
    """Have these parts asked for; return the lines that say what was compiled where."""

    def asked(*given):
        made = [Part(name, tmp_path / "note", **options) for name, options in given]
        monkeypatch.setattr(compiling, "variants_of", lambda *_, **__: made)

        def read():
            lines = (tmp_path / "note").read_text().splitlines()
            return [(name, int(process)) for name, process in map(str.split, lines)]

        return read

    return asked


def test_what_is_missing_is_compiled_in_processes_and_then_loaded_here(parts, caplog):
    read = parts(("a", {}), ("b", {}), ("c", {"compiled": True}))
    compiling.compile_kernels(SCENES, 2)
    elsewhere, here = read()[:2], read()[2:]
    assert sorted(name for name, _ in elsewhere) == ["a", "b"]
    assert os.getpid() not in {process for _, process in elsewhere}
    assert here == [(name, os.getpid()) for name in "abc"]
    assert "compiling: 0 of 2 are done of the engine's kernels" in caplog.text
    assert "compiling: 2 of 2 are done" in caplog.text


@pytest.mark.parametrize("jobs", [1, 2])
def test_what_is_compiled_is_counted_from_the_start(parts, jobs, caplog):
    parts(("a", {}), ("b", {"compiled": True}), ("c", {}))
    said = []
    compiling.compile_kernels(SCENES, jobs, compiling=lambda *one: said.append(one))
    assert [one[:2] for one in said] == [(0, 2), (1, 2), (2, 2)]
    assert {one[2] for one in said} == {"", "a", "c"}
    assert caplog.text == ""  # who counts, says it


def test_what_is_compiled_is_not_counted_again(parts):
    parts(("a", {"compiled": True}))
    compiling.compile_kernels(SCENES, 2, compiling=lambda *_: pytest.fail("nothing was missing"))


def test_a_process_that_crashes_is_named_with_what_it_compiled(parts):
    parts(("a", {}), ("b", {"dies": True}))
    with pytest.raises(GhostballError, match=r"kernels \(b\) could not be compiled: .*code 7"):
        compiling.compile_kernels(SCENES, 2)


def test_what_scenes_need_is_ready_afterwards():
    compiling.compile_kernels(SCENES, 1)
    needed = compiling.variants_of(SCENES)
    assert len(needed) == 2
    assert all(variants.are_compiled for variants in needed)
