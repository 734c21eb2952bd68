"""Tests that kernels compiled for arm64 give the bits of this machine, under emulation.

`tests/support/arm64.sh` makes the files that this needs; GHOSTBALL_ARM64 names their folder.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
SCRIPT = ROOT / "tests/support/other_machine.py"
LINKER, EMULATOR = "aarch64-linux-gnu-gcc", "qemu-aarch64-static"
FOLDER = Path(os.environ.get("GHOSTBALL_ARM64", ""))

pytestmark = [
    pytest.mark.slow,
    pytest.mark.compiled,
    pytest.mark.checkout,
    pytest.mark.skipif(
        "GHOSTBALL_ARM64" not in os.environ,
        reason="needs a Python for arm64 in GHOSTBALL_ARM64: see tests/support/arm64.sh",
    ),
]


def hashes(command, **more):
    """Return the hash of each shipped scene, as printed by a Python of a given command."""
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1", **more}
    done = subprocess.run(
        [*command, SCRIPT, "play"], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return dict(line.split() for line in done.stdout.splitlines())


def test_every_shipped_scene_has_the_same_bits_on_arm64(tmp_path):
    libraries = tmp_path / "libraries"
    target = {"GHOSTBALL_BUILD_FOR": "arm64", "CC": LINKER}
    subprocess.run(
        [sys.executable, SCRIPT, "compile", libraries], env={**os.environ, **target}, check=True
    )
    shutil.copytree(ROOT / "ghostball", tmp_path / "ghostball")  # copies the targets of links
    shutil.copytree(libraries, tmp_path / "ghostball/engine/library/shipped")
    python = [EMULATOR, "-L", FOLDER / "system", FOLDER / "system/usr/bin/python3.11"]
    found = hashes(python, PYTHONPATH=f"{tmp_path}:{FOLDER / 'site'}")
    assert len(found) > 60
    assert found == hashes([sys.executable])
