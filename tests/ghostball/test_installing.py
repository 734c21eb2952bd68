"""Fails where ghostball is not all there: in a clone without links, or in what is installed."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.checkout

ROOT = Path(__file__).parents[2]
BESIDE = ("engine", "reference_adapters", "validation", "reports")
"""The folders that are linked into the package."""


@pytest.mark.parametrize("text", ["../{}", None], ids=["links as text", "no links"])
def test_a_clone_without_symbolic_links_imports(tmp_path, text):
    # As git leaves them on Windows, and as an unpacked source archive has them.
    package = tmp_path / "ghostball"
    shutil.copytree(ROOT / "ghostball", package, ignore=lambda *_: {*BESIDE, "__pycache__"})
    for name in BESIDE:
        (tmp_path / name).symlink_to(ROOT / name)
        if text is not None:
            (package / name).write_text(text.format(name))
    code = (
        "import ghostball.engine, ghostball.reference_adapters, ghostball.validation, sys; "
        "from ghostball import Scene; import ghostball.reports; from ghostball.cli import app; "
        "print(ghostball.engine.__file__); app(['scenes', 'smoke'])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.startswith(str(tmp_path / "engine"))
    assert "half-ball-cut" in done.stdout


@pytest.mark.slow
def test_a_wheel_made_from_the_source_archive_holds_every_file(tmp_path):
    pytest.importorskip("build")
    pytest.importorskip("hatchling")
    build = [sys.executable, "-m", "build", "--no-isolation", "--outdir", tmp_path, ROOT]
    subprocess.run(build, capture_output=True, check=True)
    (wheel,) = tmp_path.glob("*.whl")
    held = set(zipfile.ZipFile(wheel).namelist())
    tracked = subprocess.run(
        ["git", "ls-files", *BESIDE, "ghostball"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split()
    files = {one if one.startswith("ghostball/") else f"ghostball/{one}" for one in tracked}
    assert files - held - {f"ghostball/{name}" for name in BESIDE} == set()
