"""Tests that the oldest numba in `pyproject.toml` and the newest compile a kernel in all ways."""

import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import small_kernel

ROOT = Path(__file__).parents[3]
NEEDS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
NEEDED = NEEDS["optional-dependencies"]["compiler"][0].partition(";")[0]
LOWEST = re.sub(r"numba>=([\d.]+),.*", r"numba==\1", NEEDED)

pytestmark = [pytest.mark.slow, pytest.mark.compiled, pytest.mark.checkout]


@pytest.mark.parametrize("wanted", [LOWEST, NEEDED])
def test_a_kernel_is_compiled_by_all_doors(wanted, tmp_path):
    pip = [sys.executable, "-m", "pip", "install", "-q", "--only-binary=:all:", "--no-compile"]
    made = subprocess.run(
        [*pip, "--target", tmp_path, wanted], capture_output=True, text=True, check=False
    )
    if "from versions: none" in made.stderr or "No module named pip" in made.stderr:
        pytest.skip("pip can't reach its registry")
    assert made.returncode == 0, made.stderr
    # These come before all installed packages: numba, llvmlite and a numpy that this numba allows.
    path = os.pathsep.join([str(tmp_path), str(ROOT)])
    done = subprocess.run(
        [sys.executable, small_kernel.__file__],
        env={**os.environ, "PYTHONPATH": path, "GHOSTBALL_CACHE_DIR": str(tmp_path / "cache")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    if "==" in wanted:
        assert f"numba=={found['numba']}".startswith(wanted)
    given = small_kernel.arguments()
    small_kernel.computed.function(*given)
    assert found["bits"] == small_kernel.bits(given)
    assert found["way"] == "Doors", done.stderr
