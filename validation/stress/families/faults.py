"""Faults around a run: engines that crash or hang, a kill, a full disk. The harness goes on."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Literal

from reference_adapters import ReferenceEngine
from validation.ensembles import Ensembles
from validation.files import ResultsError
from validation.store import ResultsFolder
from validation.stress.family import Family
from validation.stress.faulty_engine import planted
from validation.stress.records import StressFolder
from validation.stress.trial import Suite, Trial, Verdict

COMMANDS = ("validate", "stress")
Command = Literal["validate", "stress"]

TIME_LIMIT = 4.0
"""Seconds that an engine gets: a hundred times what the shots of these trials take."""

PATIENCE = 240.0
"""Seconds after which a command that should have ended hangs."""

FILE_SIZE = 24 * 1024
"""Bytes past which no file can be written, where the disk is full: room for a few cases."""

_TOML = """\
schema = 1
name = "{name}"
[[balls]]
id = "cue"
position = [0.0, 0.0]
velocity = [0.1, 0.0]
"""

_ON_A_FULL_DISK = """
import resource

resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, {size}))
from ghostball.cli import main

main()
"""

_STRESS_TRIALS = ("grazing/rolling-*-1e-01", "grazing/rolling-*-1e-04")


@dataclass(frozen=True)
class Ended:
    """How a command ended."""

    status: int
    errors: str


class Place:
    """A temporary folder with the faulty engine planted, in which commands are run."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.out = folder / "out"
        site = planted(folder / "site")
        path = os.pathsep.join([str(site), *(part for part in sys.path if part)])
        self._environment = os.environ | {"PYTHONPATH": path}

    def scenes(self, count: int) -> list[str]:
        """Write scenes of a moment, and return their paths."""
        paths = []
        for k in range(count):
            path = self.folder / f"roll-{k}.toml"
            path.write_text(_TOML.format(name=f"roll-{k}"))
            paths.append(str(path))
        return paths

    def arguments(
        self, command: Command, engines: Sequence[str], jobs: int, many: int
    ) -> list[str]:
        """Return the command line that tries `engines` on `many` scenes, or on some trials."""
        what = self.scenes(many) if command == "validate" else list(_STRESS_TRIALS[:many])
        return [
            command,
            *what,
            *("--engines", ",".join(engines)),
            *("--out", str(self.out)),
            *("--jobs", str(jobs)),
            *("--time-limit", str(TIME_LIMIT)),
            "--no-report",
        ]

    def start(
        self, arguments: Sequence[str], file_size: int | None = None
    ) -> subprocess.Popen[str]:
        """Start a command; `file_size` [B] is the most that it can write into a file."""
        module = ["-m", "ghostball"]
        if file_size is not None:
            module = ["-c", _ON_A_FULL_DISK.format(size=file_size)]
        return subprocess.Popen(
            [sys.executable, *module, *arguments],
            env=self._environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )

    def run(self, arguments: Sequence[str], file_size: int | None = None) -> Ended:
        """Run a command to its end.

        Raises
        ------
        subprocess.TimeoutExpired
            Where it hangs.
        """
        process = self.start(arguments, file_size)
        try:
            _, errors = process.communicate(timeout=PATIENCE)
        finally:
            process.kill()
            process.wait()
        return Ended(process.returncode, errors)


def outcomes(command: Command, out: Path) -> dict[tuple[str, str], tuple[str, str]]:
    """Return what a folder of results says: outcome and reason, by scene or trial, and engine.

    Raises
    ------
    ResultsError
        Where it can't be read.
    """
    if command == "validate":
        return {
            (one.scene, one.label): (one.outcome, one.reason)
            for one in ResultsFolder.load(out).cases
        }
    return {
        (one.trial, one.label): (one.outcome, "; ".join(one.faults))
        for one in StressFolder.load(out).findings
    }


SOUND = {"validate": "ran", "stress": "survived"}
"""Outcome where nothing failed."""

FAILED = {"validate": "failed", "stress": "broken"}
"""Outcome where the engine did."""

SAYS = {
    "raise": "RuntimeError: lost the balls",
    "exit": "SystemExit: 0",
    "die": "exit code 7",
    "abort": "exit code -9",
    "hang": "took longer than",
    "deaf": "took longer than",
    "freeze": "took longer than",
    "garbage": "ValueError",
}
"""What is said of each fault."""


def check_outcomes(
    command: Command,
    found: dict[tuple[str, str], tuple[str, str]],
    ways: Sequence[str],
    planned: int,
) -> list[str]:
    """Return what is wrong with the results of a run with faulty engines beside sound ones."""
    faults = []
    if len(found) != planned:
        faults.append(f"{len(found)} of {planned} results are there: the faults cost some")
    for (name, label), (outcome, reason) in found.items():
        does = label.partition("does=")[2]
        if does not in ways:
            if outcome != SOUND[command]:
                faults.append(
                    f"{name} on {label}: {outcome}, though it does nothing wrong: {reason}"
                )
        elif outcome != FAILED[command] or SAYS[does] not in reason:
            faults.append(
                f"{name} on {label}: {outcome} for the reason {reason!r}, which should say "
                f"{SAYS[does]!r}"
            )
    return faults


class FaultTrial(Trial):
    """About the harness: what it does is the same whatever the engine that is asked."""

    limit: ClassVar[float] = 2.0 * PATIENCE
    small: ClassVar[bool] = False

    def run(self, engine: ReferenceEngine) -> Verdict:  # noqa: ARG002 - about the harness
        """Try it, in a temporary folder."""
        with tempfile.TemporaryDirectory() as folder:
            try:
                faults = self.faults(Place(Path(folder)))
            except subprocess.TimeoutExpired:
                faults = [f"the command hangs: it didn't end within {PATIENCE:g} s"]
            except ResultsError as error:
                faults = [f"the results can't be read: {error}"]
        return Verdict(tuple(faults), None, float(bool(faults)), 1, int(bool(faults)))

    def faults(self, place: Place) -> list[str]:
        """Return what is wrong."""
        raise NotImplementedError


@dataclass(frozen=True)
class FaultyEngines(FaultTrial):
    """Engines that crash and hang: each costs its scene, and all others go on.

    Attributes
    ----------
    name : str
    command : "validate" or "stress"
    ways : tuple of str
        What the engines do.
    jobs : int
    """

    name: str
    command: Command
    ways: tuple[str, ...]
    jobs: int

    def faults(self, place: Place) -> list[str]:
        """Return what is wrong."""
        engines = ["faulty", *(f"faulty:does={way}" for way in self.ways)]
        ended = place.run(place.arguments(self.command, [*engines, "ghostball"], self.jobs, 1))
        found = outcomes(self.command, place.out)
        names = {name for name, _ in found}
        planned = len(names) * (len(engines) + 1)
        faults = check_outcomes(self.command, found, self.ways, planned)
        # A suite says that the harness failed to run a scene; a stress run asks for our engine.
        status = 3 if self.command == "validate" else 0
        if ended.status != status:
            faults.append(f"exit status {ended.status} instead of {status}: {ended.errors[-500:]}")
        if "Traceback" in ended.errors:
            faults.append(f"a traceback is shown: {ended.errors[-1000:]}")
        return faults


@dataclass(frozen=True)
class FaultyMembers(FaultTrial):
    """A perturbed shot that hangs: the ensemble goes on, and says so.

    Attributes
    ----------
    name : str
    way : str
    """

    name: str
    way: str

    def faults(self, place: Place) -> list[str]:
        """Return what is wrong."""
        label = f"faulty:does={self.way}"
        arguments = place.arguments("validate", ["ghostball", label], 1, 1)
        ended = place.run([*arguments, "--ensemble", "2"])
        ensembles = Ensembles.load(place.out)
        if ensembles is None:
            return [f"there are no ensembles: {ended.errors[-500:]}"]
        records = ensembles.of("roll-0")
        reasons = list(records[label].failed.values())
        faults = []
        if len(reasons) != 2 or not all(SAYS[self.way] in reason for reason in reasons):
            faults.append(f"of 2 members that fail is said: {reasons}")
        if records["ghostball"].failed:
            faults.append("members of our engine fail")
        if ended.status != 3:
            faults.append(f"exit status {ended.status} instead of 3")
        return faults


@dataclass(frozen=True)
class Killed(FaultTrial):
    """Killed in the midst of a run: what is done reads back, and a next run goes on from there.

    Attributes
    ----------
    name : str
    command : "validate" or "stress"
    """

    name: str
    command: Command

    def faults(self, place: Place) -> list[str]:
        """Return what is wrong."""
        engines = ["ghostball", "faulty:slow=0.5"]
        arguments = place.arguments(self.command, engines, 1, 2)
        lines = "results.jsonl" if self.command == "validate" else "stress.jsonl"
        process = place.start(arguments)
        try:
            before = _wait_for_lines(process, place.out / lines, 3)
        finally:
            process.kill()
            process.communicate()
        left = outcomes(self.command, place.out)
        faults = []
        if len(left) < 2 or len(left) < before - 1:
            faults.append(f"of {before} lines that were written, {len(left)} read back")
        ended = place.run(arguments)
        found = outcomes(self.command, place.out)
        faults += check_outcomes(self.command, found, (), len(found))
        if ended.status not in (0, 1):
            faults.append(f"run again, it ends in {ended.status}: {ended.errors[-500:]}")
        if lost := left.keys() - found.keys():
            faults.append(f"run again, it has lost {lost}")
        if "taken over" not in ended.errors and "are known" not in ended.errors:
            faults.append(f"run again, nothing is taken over: {ended.errors[-500:]}")
        return faults


def _wait_for_lines(process: subprocess.Popen[str], path: Path, count: int) -> int:
    """Wait until a file has that many lines; return how many it has."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline and process.poll() is None:
        found = path.read_bytes().count(b"\n") if path.exists() else 0
        if found >= count:
            return found
        time.sleep(0.02)
    if process.poll() is None:
        raise subprocess.TimeoutExpired(process.args, PATIENCE)
    return path.read_bytes().count(b"\n") if path.exists() else 0


@dataclass(frozen=True)
class FullDisk(FaultTrial):
    """The disk is full in the midst of a run: it says so, and what was written reads back.

    Attributes
    ----------
    name : str
    command : "validate" or "stress"
    """

    name: str
    command: Command

    def faults(self, place: Place) -> list[str]:
        """Return what is wrong."""
        engines = ["ghostball", *(f"faulty:slow={k}e-9" for k in range(1, 9))]
        arguments = place.arguments(self.command, engines, 1, 2)
        ended = place.run(arguments, FILE_SIZE)
        left = outcomes(self.command, place.out)
        faults = check_outcomes(self.command, left, (), len(left))
        if not left:
            faults.append("nothing reads back")
        if ended.status not in (2, 3) or "can't" not in ended.errors:
            faults.append(f"it doesn't say so: exit status {ended.status}: {ended.errors[-800:]}")
        if "Traceback" in ended.errors:
            faults.append(f"a traceback is shown: {ended.errors[-1500:]}")
        again = place.run(arguments)
        found = outcomes(self.command, place.out)
        faults += check_outcomes(self.command, found, (), len(found))
        if again.status not in (0, 1) or len(found) <= len(left):
            faults.append(
                f"with room again, it ends in {again.status} with {len(found)} results: "
                f"{again.errors[-500:]}"
            )
        return faults


def _trials(suite: Suite) -> Iterator[Trial]:
    few, all_ways = ("die", "hang"), tuple(SAYS)
    ways = all_ways if suite == "full" else few
    if os.name == "nt":  # these signals and limits are POSIX
        ways = few
    yield FaultyEngines("validate-engines-1-job", "validate", ways, 1)
    if suite == "full":
        yield FaultyEngines("validate-engines-2-jobs", "validate", ways, 2)
        yield FaultyEngines("stress-engines-1-job", "stress", ways, 1)
        yield FaultyEngines("stress-engines-2-jobs", "stress", ways, 2)
        yield FaultyMembers("ensemble-members-die", "die")
        yield FaultyMembers("ensemble-members-hang", "hang")
        yield Killed("validate-killed", "validate")
        if os.name != "nt":
            yield FullDisk("validate-full-disk", "validate")
            yield FullDisk("stress-full-disk", "stress")
    yield Killed("stress-killed", "stress")


FAMILY = Family(
    "faults",
    "Faults around a run",
    "An engine that crashes or hangs costs its scene and no other; a run that is killed, or whose "
    "disk is full, leaves results that read back, and a next one goes on from there.",
    _trials,
    ours_alone=True,
)
