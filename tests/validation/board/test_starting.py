"""What the time of an engine's start is of: fails where what all engines share counts for one."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from ghostball.validation.board.starting import start_time

RECORDING = """
import atexit, json, sys
from ghostball.validation.board import starting

spec, seconds, modules = sys.argv[1:]
loaded = []

def read_clock():
    loaded.append(set(sys.modules))
    return float(len(loaded))

def write_modules():
    with open(modules, "w") as file:
        json.dump(sorted(loaded[1] - loaded[0]), file)

starting._processor_time = read_clock
atexit.register(write_modules)  # called after the clock is read the second time
starting.play_first(spec, seconds)
"""


def loaded_while_timed(spec: str, tmp_path) -> list[str]:
    """Return the modules that come between the two readings of the clock."""
    seconds, modules = tmp_path / "seconds", tmp_path / "modules.json"
    subprocess.run([sys.executable, "-c", RECORDING, spec, seconds, modules], check=True)
    assert seconds.read_text() == "1.0"
    return json.loads(modules.read_text())


def test_only_what_the_engine_brings_is_loaded_while_the_clock_runs(tmp_path):
    new = loaded_while_timed("pymunk", tmp_path)
    assert "pymunk" in new
    ours = {one for one in new if one.startswith("ghostball.")}
    assert {one for one in ours if not one.startswith("ghostball.reference_adapters.")} == set()
    assert not {"numba", "numpy", "pydantic"} & set(new)


@pytest.mark.compiled
def test_the_compiler_counts_for_our_own_engine(tmp_path):
    assert "numba" in loaded_while_timed("ghostball", tmp_path)


def test_an_engine_that_fails_has_no_time():
    with pytest.raises(subprocess.CalledProcessError):
        start_time("pymunk:max_steps=10")
