"""The installed package is complete, and independent of packages in the user's project."""

from __future__ import annotations

import importlib
import os
import pkgutil
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import ghostball

ROOT = Path(__file__).parents[2]
PARTS = ("engine", "reference_adapters", "validation", "reports")
"""Folders that are linked into the package; other packages may have the same names."""

PACKAGES = {one.name for one in pkgutil.iter_modules(ghostball.__path__) if one.ispkg}
LIBRARY = ["", *sorted(PACKAGES - {"cli", "pytest_plugin"})]
"""Packages that users import."""


def run(*command, folder=None, **environment):
    done = subprocess.run(
        [*map(str, command)],
        cwd=folder,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_command_is_installed_and_is_the_module():
    command = Path(sys.executable).parent / "ghostball"
    for start in ([command], [sys.executable, "-m", "ghostball"]):
        assert run(*start, "--version").startswith("ghostball ")


@pytest.mark.checkout
def test_without_its_packages_the_module_says_what_to_install():
    # With -S, Python finds no installed package.
    done = subprocess.run(
        [sys.executable, "-S", "-m", "ghostball", "validate"],
        cwd=ROOT,
        env={"PATH": os.environ["PATH"]},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert "pip install '.[compiler]'" in done.stderr
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize("name", LIBRARY)
def test_no_name_of_a_package_hides_a_module_of_it(name):
    """`import engine.simulate as m` once gave a function, because a module had the same name."""
    package = f"ghostball.{name}".rstrip(".")
    loaded = importlib.import_module(package)
    for module in pkgutil.iter_modules(loaded.__path__):
        named = vars(loaded).get(module.name)
        assert named is None or named.__name__ == f"{package}.{module.name}"


def test_each_name_on_the_page_of_python_is_imported_from_ghostball():
    page = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    names = [where.rpartition(".")[2] for where in re.findall(r"^::: (\S+)", page, re.M)]
    assert len(names) > 20
    assert [name for name in names if name not in ghostball.__all__] == []


@pytest.mark.checkout
@pytest.mark.parametrize("text", ["../{}", None], ids=["links as text", "no links"])
def test_a_clone_without_symbolic_links_imports(tmp_path, text):
    # As git creates links on Windows, and as in an unpacked source archive.
    package = tmp_path / "ghostball"
    shutil.copytree(ROOT / "ghostball", package, ignore=lambda *_: {*PARTS, "__pycache__"})
    for name in PARTS:
        (tmp_path / name).symlink_to(ROOT / name)
        if text is not None:
            (package / name).write_text(text.format(name))
    code = (
        "import ghostball.engine, ghostball.reference_adapters, ghostball.validation, sys; "
        "from ghostball import Scene; import ghostball.reports; from ghostball.cli import app; "
        "print(ghostball.engine.__file__); app(['scenes', 'smoke'])"
    )
    printed = run(sys.executable, "-c", code, folder=tmp_path, PYTHONPATH=str(tmp_path))
    assert printed.startswith(str(tmp_path / "engine"))
    assert "half-ball-cut" in printed


@pytest.mark.slow
@pytest.mark.checkout
def test_a_wheel_made_from_the_source_archive_holds_every_file(tmp_path):
    pytest.importorskip("build")
    pytest.importorskip("hatchling")
    run(sys.executable, "-m", "build", "--no-isolation", "--outdir", tmp_path, ROOT)
    (wheel,) = tmp_path.glob("*.whl")
    held = set(zipfile.ZipFile(wheel).namelist())
    tracked = run("git", "ls-files", *PARTS, "ghostball", folder=ROOT).split()
    files = {one if one.startswith("ghostball/") else f"ghostball/{one}" for one in tracked}
    assert files - held - {f"ghostball/{name}" for name in PARTS} == set()


# --- in another project's environment


@pytest.fixture
def project(tmp_path):
    """A project with a package of each name, and with its own engine."""
    for name in PARTS:
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("whose = 'theirs'\n")
    (tmp_path / "engine" / "mine.py").write_text(
        "from ghostball.validation.examples.stepper import Stepper\n\n\n"
        "class Mine(Stepper):\n    name = 'mine'\n"
    )
    return tmp_path


def test_both_are_imported_and_pytest_finds_an_engine_in_a_package_called_engine(project):
    # Fails if a part of Ghostball is imported, or found, by a name that other packages may use.
    guest = {"folder": project, "PYTHONPATH": str(project), "NUMBA_DISABLE_JIT": "1"}
    ours = "; ".join(f"import ghostball.{name}" for name in PARTS)
    ours += "; from ghostball import Results, Scene, find_scene, simulate"
    ours += "; assert isinstance(find_scene('stop'), Scene)"
    theirs = "; ".join(f"import {name}; assert {name}.whose == 'theirs'" for name in PARTS)
    run(sys.executable, "-c", f"{ours}; {theirs}", **guest)
    plugin = ("--ghostball", "--ghostball-engine", "engine.mine:Mine")
    quiet = ("-m", "pytest", "-q", "--rootdir", ".", "--collect-only")
    assert "stop" in run(sys.executable, *quiet, *plugin, **guest)


@pytest.mark.checkout
def test_by_its_short_name_a_part_refuses_to_be_a_second_one():
    for name in PARTS:
        import_it = [sys.executable, "-c", f"import {name}"]
        done = subprocess.run(import_it, cwd=ROOT, capture_output=True, text=True, check=False)
        assert done.returncode == 1
        assert f"is part of ghostball: import `ghostball.{name}`" in done.stderr
