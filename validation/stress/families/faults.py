"""Faults around a run: engines that crash or hang, a kill, a full disk. The harness goes on."""

from __future__ import annotations

import os
import subprocess
import tempfile
import time
from abc import abstractmethod
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from reference_adapters import ReferenceEngine
from validation.ensembles import Ensembles
from validation.files import ResultsError
from validation.stress.commands import LINES_FILE, PATIENCE, Asked, Command, Ended, Outcomes, Place
from validation.stress.family import Family
from validation.stress.trial import Suite, Trial, Verdict

FILE_SIZE = 24 * 1024
"""Bytes past which no file can be written, where the disk is full: room for a few cases."""

WAITS = 3
"""How often a trial waits at most, for `PATIENCE` each time."""

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
    "give-up": "lost the cue",
    "miscount": "got -3",
}
"""What is said of each fault."""


def check_outcomes(command: Command, found: Outcomes, ways: Sequence[str] = ()) -> list[str]:
    """Return what is wrong with results on faulty engines, which do `ways`, and on sound ones."""
    faults = []
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


def check_whole(
    found: Collection[tuple[str, str]], asked: Collection[tuple[str, str]]
) -> list[str]:
    """Return which of the results that were asked for are missing, and which weren't asked for."""
    faults = [
        f"{name} on {label}: no result, one of {len(asked)} that were asked for"
        for name, label in sorted(set(asked) - set(found))
    ]
    faults += [
        f"{name} on {label}: a result that was not asked for"
        for name, label in sorted(set(found) - set(asked))
    ]
    return faults


def check_quiet(errors: str) -> list[str]:
    """Return what is wrong with messages: a fault around a run is no reason for a traceback."""
    return [f"a traceback is shown: {errors[-1500:]}"] if "Traceback" in errors else []


class FaultTrial(Trial):
    """About the harness: what it does is the same whatever the engine that is asked."""

    # More than all that it may wait for: it says itself what hangs.
    limit: ClassVar[float] = (WAITS + 0.5) * PATIENCE
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

    @abstractmethod
    def faults(self, place: Place) -> list[str]:
        """Return what is wrong; waits `WAITS` times at most."""


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
        faulty = tuple(f"faulty:does={way}" for way in self.ways)
        asked = Asked(self.command, ("faulty", *faulty, "ghostball"), 1, self.jobs)
        ended = place.run(asked.arguments(place))
        found = asked.outcomes(place)
        faults = check_whole(found, asked.results) + check_outcomes(self.command, found, self.ways)
        # A suite fails by any engine that does; a stress run asks for our engine.
        status = 1 if self.command == "validate" else 0
        if ended.status != status:
            faults.append(f"exit status {ended.status} instead of {status}: {ended.errors[-500:]}")
        return faults + check_quiet(ended.errors)


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
        asked = Asked("validate", ("ghostball", label), 1)
        ended = place.run([*asked.arguments(place), "--ensemble", "2"])
        ensembles = Ensembles.load(place.out)
        if ensembles is None:
            return [f"there are no ensembles: {ended.errors[-500:]}"]
        records = ensembles.of(asked.names[0])
        reasons = list(records[label].failed.values())
        faults = []
        if len(reasons) != 2 or not all(SAYS[self.way] in reason for reason in reasons):
            faults.append(f"of 2 members that fail is said: {reasons}")
        if records["ghostball"].failed:
            faults.append("members of our engine fail")
        if ended.status != 1:
            faults.append(f"exit status {ended.status} instead of 1")
        return faults


class CutShort(FaultTrial):
    """A run that doesn't come to its end: what it did reads back, a next one goes on from there."""

    command: Command

    @property
    @abstractmethod
    def asked(self) -> Asked:
        """What the run is asked for."""

    @abstractmethod
    def cut(self, place: Place, arguments: list[str]) -> tuple[int, list[str]]:
        """Start the run and cut it short; return how many results are there at least, and faults.

        Waits twice at most.
        """

    def faults(self, place: Place) -> list[str]:
        """Return what is wrong."""
        asked = self.asked
        arguments = asked.arguments(place)
        least, faults = self.cut(place, arguments)
        left = asked.outcomes(place)
        faults += check_outcomes(self.command, left)
        if len(left) < least:
            faults.append(f"of {least} results that were written, {len(left)} read back")
        return faults + check_next_run(asked, left, place.run(arguments), asked.outcomes(place))


def check_next_run(asked: Asked, left: Outcomes, ended: Ended, found: Outcomes) -> list[str]:
    """Return what is wrong with the run after one that was cut short.

    Parameters
    ----------
    asked : Asked
        Of both.
    left, found : mapping
        What the folder held before it, and after.
    ended : Ended
    """
    faults = check_outcomes(asked.command, found) + check_whole(found, asked.results)
    if ended.status not in (0, 1):
        faults.append(f"run again, it ends in {ended.status}: {ended.errors[-500:]}")
    if left and "taken over" not in ended.errors and "are known" not in ended.errors:
        faults.append(f"run again, nothing is taken over: {ended.errors[-500:]}")
    return faults


@dataclass(frozen=True)
class Killed(CutShort):
    """Killed in the midst of a run; what it had started ends by itself, without a word.

    Attributes
    ----------
    name : str
    command : "validate" or "stress"
    count : int
        Scenes, or trials.
    """

    name: str
    command: Command
    count: int = 2

    @property
    def asked(self) -> Asked:
        """A slow engine, to be caught in the midst of a shot."""
        return Asked(self.command, ("ghostball", "faulty:slow=0.5"), self.count)

    def cut(self, place: Place, arguments: list[str]) -> tuple[int, list[str]]:
        """Kill the command, and it alone, once there are two results."""
        lines = place.out / LINES_FILE[self.command]
        header = int(self.command == "stress")
        with place.start(arguments) as process:
            written = _wait_for_lines(process, lines, header + 2) - header
            process.kill()
            _, errors = process.communicate(timeout=PATIENCE)
        return max(written, 2), check_quiet(errors)


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
class FullDisk(CutShort):
    """The disk is full in the midst of a run: it says so.

    Attributes
    ----------
    name : str
    command : "validate" or "stress"
    """

    name: str
    command: Command

    @property
    def asked(self) -> Asked:
        """More than there is room for."""
        engines = ("ghostball", *(f"faulty:slow={k}e-9" for k in range(1, 9)))
        return Asked(self.command, engines, 4)

    def cut(self, place: Place, arguments: list[str]) -> tuple[int, list[str]]:
        """Run until the disk is full."""
        ended = place.run(arguments, FILE_SIZE)
        return 1, check_told(ended)


def check_told(ended: Ended) -> list[str]:
    """Return what is wrong with how a run ends that finds the disk full."""
    faults = check_quiet(ended.errors)
    if ended.status not in (2, 3) or "can't" not in ended.errors:
        faults.append(f"it doesn't say so: exit status {ended.status}: {ended.errors[-800:]}")
    return faults


def _trials(suite: Suite) -> Iterator[Trial]:
    few, all_ways = ("die", "hang"), tuple(SAYS)
    ways = all_ways if suite == "full" else few
    if os.name == "nt":  # these signals and limits are POSIX
        ways = few
    # Two jobs, so that the others go on while one hangs.
    yield FaultyEngines("validate-engines-2-jobs", "validate", ways, 2)
    if suite == "full":
        yield FaultyEngines("validate-engines-1-job", "validate", ways, 1)
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
