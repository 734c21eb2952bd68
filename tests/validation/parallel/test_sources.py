"""The hash of the code includes every source file."""

from __future__ import annotations

import sys
from importlib.metadata import packages_distributions, version
from importlib.util import find_spec
from pathlib import Path

import pytest

import ghostball.validation.parallel.sources
from ghostball.validation.parallel.sources import (
    OUR_PACKAGES,
    _owners,
    code_files,
    code_kind,
    engine_code,
    hash_sources,
    source_folders,
)

# Folder of the packages: a checkout, or the folder of an installed wheel.
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
    (inner / "capabilities.toml").write_text("[p.always]")  # decides which scenes are refused
    hashes.append(hash_sources(folders))
    (tmp_path / "p" / "a.py").write_text("x = 1y")  # the joined contents of the files are unchanged
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
        # A wheel contains the libraries of the kernels.
        for name in ("*.py", "*.mjs", "*.so", "capabilities.toml")
        for path in (ROOT / p).rglob(name)
    }
    assert hashed == wanted
    assert "model/impact_laws.py" in hashed


ENGINE = """
def simulate(scene):
    import helper_of_engine, numpy, missing_module, pymunk
"""
FILES = {
    "engine_of_guest.py": ENGINE,
    "helper_of_engine/__init__.py": "from package_of_helper.part import x",
    "helper_of_engine/part.py": "not Python",
    "package_of_helper/part.py": "x = 1",
}


@pytest.fixture
def guest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder of an engine that imports modules which aren't installed."""
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.syspath_prepend(str(tmp_path))
    for name in [one for one in sys.modules if one.startswith("engine_of_guest")]:
        monkeypatch.delitem(sys.modules, name)
    return tmp_path


NAME = "engine_of_guest:simulate"
SOURCE = f"the source of engine `{NAME}`"


@pytest.mark.parametrize("name", FILES)
def test_the_code_of_an_engine_is_its_module_and_all_that_this_imports(guest: Path, name: str):
    before = engine_code(NAME)
    assert engine_code(NAME) == before
    assert before["numpy"] == version("numpy")
    assert before["cffi"] == version("cffi")  # pymunk requires it
    (guest / "unrelated.py").write_text("x = 2")
    assert engine_code(NAME) == before
    (guest / name).write_text(FILES[name] + "\n# edited")
    assert engine_code(NAME)[SOURCE] != before[SOURCE]


def test_the_code_of_an_engine_is_the_same_in_another_folder(
    guest: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = engine_code(NAME)
    other = guest.parent / "other"
    guest.rename(other)
    for name in ("engine_of_guest", "helper_of_engine", "package_of_helper"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.syspath_prepend(str(other))
    assert engine_code(NAME) == before


@pytest.mark.usefixtures("guest")
def test_engines_of_another_project_have_a_kind_each() -> None:
    labels = ["ghostball", "pymunk:contact_steps=exact", NAME, "no_such_module:simulate"]
    assert [code_kind(one) for one in labels] == ["", "", NAME, "no_such_module:simulate"]
    assert engine_code("") == {}


def test_owners_of_modules_are_those_that_importlib_finds() -> None:
    path = tuple(one for one in sys.path if any(Path(one).glob("*-info")))
    found = _owners(path)
    assert {"numpy", "pytest", "yaml"} <= set(found)
    for module, names in packages_distributions().items():
        if module.isidentifier() and find_spec(module) is not None:
            assert {one.metadata["Name"] for one in found[module]} >= set(names), module
