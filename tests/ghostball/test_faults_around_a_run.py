"""Faults around a run: engines that crash or hang, kills, a full disk. Ghostball continues.

The commands run in separate processes, with an engine whose setting selects its fault.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time

import numpy as np
import pytest
from faulty_engine import FaultyEngine, planted

from ghostball.validation.results.files import ResultsError
from ghostball.validation.results.store import Results

TIME_LIMIT = 8.0
"""Time limit of an engine [s], hundreds of times the time for these shots."""

PATIENCE = 240.0
"""Time after which a command counts as hanging [s]."""

FILE_SIZE = 128 * 1024
"""Largest size of a file on the full disk [bytes], enough for a few results."""

SAYS = {
    "raise": "RuntimeError: lost the balls",
    "exit": "SystemExit: 0",
    "crash": "exit code 7",
    "abort": "exit code -9",
    "hang": "exceeded the time limit of",
    "deaf": "exceeded the time limit of",
    "freeze": "exceeded the time limit of",
    "garbage": "ValueError",
    "give-up": "lost the cue",
    "miscount": "got -3",
}
"""Part of the message for each fault."""

SCENE = """\
schema = 1
name = "{name}"
[[balls]]
id = "cue"
position = [0.0, 0.0]
velocity = [0.1, 0.0]
"""

SHOTS = [f"rolling-{kind}-{depth}" for depth in ("1e-01", "1e-04") for kind in ("hit", "miss")]

COMMANDS = pytest.mark.parametrize("command", ["validate", "stress"])


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Work in an empty folder in which the faulty engine counts as installed for every process."""
    path = [str(planted(tmp_path / "site")), *filter(None, sys.path)]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(path))
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    return tmp_path / "here"


class Asked:
    """A command that runs `count` scenes, or generated shots (4 at most), on some engines."""

    def __init__(self, command, engines, count=1, jobs=1):
        self.command = command
        if command == "validate":
            names = [f"roll-{k}" for k in range(count)]
            for name in names:
                with open(f"{name}.toml", "w") as file:
                    file.write(SCENE.format(name=name))
            given = [f"{name}.toml" for name in names]
        else:
            names = [f"grazing.{name}" for name in SHOTS[:count]]
            given = [name.replace(".", "/") for name in names]
        self.results = {(name, label) for name in names for label in engines}
        self.arguments = [command, *given, *(f"-e{one}" for one in engines), "--jobs", str(jobs)]
        self.arguments += ["--time-limit", f"{TIME_LIMIT:g}", "--out", "out"]
        if command == "validate":
            self.arguments.append("--no-report")

    def start(self, *more, first=""):
        """Start the command; `first`: Python code that runs before it."""
        program = f"{first}\nfrom ghostball.cli import main\nmain()"
        return subprocess.Popen(
            [sys.executable, "-c", program, *self.arguments, *more],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def run(self, *more, first=""):
        """Run the command to its end; return its exit status and what it says."""
        with self.start(*more, first=first) as process:
            try:
                _, errors = process.communicate(timeout=PATIENCE)
            finally:
                process.kill()
        assert "Traceback" not in errors
        return process.returncode, errors

    def outcomes(self):
        """Return outcome and reason of each stored result, by scene and engine."""
        cases = Results.open("out").cases
        return {(one.scene, one.label): (one.outcome, one.reason) for one in cases}

    def done(self):
        """Return scene and engine of each result stored so far."""
        try:
            return set(self.outcomes())
        except ResultsError:
            return set()

    def assert_outcomes(self, found):
        """Assert that exactly the faulty engines fail, and that the output names their faults."""
        for (name, label), (outcome, reason) in found.items():
            does = label.partition("does=")[2]
            assert outcome == ("failed" if does else "ran"), (name, label, reason)
            assert SAYS.get(does, "") in reason

    def assert_continues(self, least):
        """Assert that an interrupted run stored at least `least` results; finish it."""
        left = self.outcomes()
        assert len(left) >= least
        self.assert_outcomes(left)
        status, errors = self.run()
        assert status == 0, errors
        assert ("reused" in errors) == bool(left)
        found = self.outcomes()
        assert set(found) == self.results
        self.assert_outcomes(found)


def test_every_fault_has_its_words():
    ways = set(FaultyEngine.Settings.model_fields["does"].annotation.__args__)
    # Stopping early and printing have different outcomes. A motion that can't be sampled matters
    # only for commands that need the motion (`test_faulty_engines.py`).
    assert ways == {"none", "stop", "print", "lose-motion", "cut-motion", *SAYS}


@pytest.mark.slow
@COMMANDS
@pytest.mark.usefixtures("here")
def test_an_engine_that_crashes_or_hangs_costs_its_own_results_alone(command):
    faulty = [f"faulty:does={way}" for way in SAYS]
    asked = Asked(command, ["faulty", *faulty, "ghostball"], jobs=2)
    status, errors = asked.run()
    # A run fails if any engine fails, a stress run if any named engine fails.
    assert status == 1, errors
    found = asked.outcomes()
    assert set(found) == asked.results
    asked.assert_outcomes(found)


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="limits of files are POSIX")
@COMMANDS
@pytest.mark.usefixtures("here")
def test_a_full_disk_is_said_and_a_next_run_continues_from_there(command):
    asked = Asked(command, ["ghostball", *(f"faulty:slow={k}e-9" for k in range(1, 9))], count=4)
    limit = f"({FILE_SIZE}, {FILE_SIZE})"
    full = f"import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, {limit})"
    status, errors = asked.run(first=full)
    assert status in (2, 3), errors
    assert "can't" in errors
    asked.assert_continues(least=1)


class OnCluster:
    """A command on a cluster of two workers, disturbed after the first result of Ghostball."""

    def __init__(self, asked, folder):
        pytest.importorskip("distributed", reason="needs Dask: pip install '.[cluster]'")
        self._asked, self._folder = asked, folder

    def run(self, interfere):
        """Run the command to its end; return its exit status and what it says."""
        from dask_cluster import dask_cluster

        with (
            dask_cluster(self._folder) as cluster,
            self._asked.start("--cluster", cluster.address) as process,
        ):
            deadline = time.monotonic() + PATIENCE
            while not any(label == "ghostball" for _, label in self._asked.done()):
                assert process.poll() is None
                assert time.monotonic() < deadline
                time.sleep(0.02)
            interfere(cluster)
            _, errors = process.communicate(timeout=PATIENCE)
        assert "Traceback" not in errors
        return process.returncode, errors


def numbers():
    """Return all results of a run except times, by scene and engine."""
    return {
        (one.scene, one.label): (
            one.outcome,
            one.reason,
            {name: value for name, value in one.metrics.items() if name != "wall_time"},
            one.checks,
            np.asarray(one.rest_positions).tolist(),
        )
        for one in Results.open("out").cases
    }


@pytest.mark.slow
def test_a_cluster_with_a_killed_worker_has_the_results_of_one_machine(here, tmp_path):
    asked = Asked("validate", ["ghostball", "faulty:slow=1.0", "faulty:does=crash"], count=2)
    status, _ = OnCluster(asked, tmp_path).run(lambda cluster: cluster.workers[0].kill())
    found = numbers()
    assert set(found) == asked.results
    shutil.rmtree("out")
    assert asked.run()[0] == status
    assert numbers() == found
