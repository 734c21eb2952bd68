"""Commands of ours, run for real beside an engine that fails as it is told."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from validation.leash import COMMAND, leashed
from validation.store import ResultsFolder
from validation.stress.faulty_engine import planted
from validation.stress.records import StressFolder

Command = Literal["validate", "stress"]

LINES_FILE = {"validate": "results.jsonl", "stress": "stress.jsonl"}
"""Where a command writes a line for each result."""

TIME_LIMIT = 2.5
"""Seconds that an engine gets: a hundred times what the shots of these trials take."""

PATIENCE = 240.0
"""Seconds after which a command that should have ended hangs."""

_TOML = """\
schema = 1
name = "{name}"
[[balls]]
id = "cue"
position = [0.0, 0.0]
velocity = [0.1, 0.0]
"""

_SMALL_FILES = """
import resource

resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, {size}))
"""

_STRESS_TRIALS = tuple(
    f"rolling-{kind}-{depth}" for depth in ("1e-01", "1e-04") for kind in ("hit", "miss")
)
"""Of the family "grazing"."""

Outcomes = dict[tuple[str, str], tuple[str, str]]
"""Outcome and reason, by scene or trial, and engine."""


@dataclass(frozen=True)
class Ended:
    """How a command ended."""

    status: int
    output: str
    errors: str


def ghostball(
    arguments: Sequence[str], environment: dict[str, str] | None = None, first: str = ""
) -> AbstractContextManager[subprocess.Popen[str]]:
    """Start a command of ours on a leash; `first` is Python to be run before it."""
    return leashed([sys.executable, "-c", COMMAND.format(first=first), *arguments], environment)


def ended(running: AbstractContextManager[subprocess.Popen[str]], timeout: float) -> Ended:
    """Wait for the end of a command.

    Raises
    ------
    subprocess.TimeoutExpired
        Where it doesn't end in `timeout` seconds; nothing is left of it then.
    """
    with running as process:
        output, errors = process.communicate(timeout=timeout)
    return Ended(process.returncode, output, errors)


class Place:
    """A temporary folder with the faulty engine planted, in which commands are run.

    Parameters
    ----------
    folder : Path
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.out = folder / "out"
        site = planted(folder / "site")
        path = os.pathsep.join([str(site), *(part for part in sys.path if part)])
        self._environment = os.environ | {"PYTHONPATH": path}

    def run(self, arguments: Sequence[str], file_size: int | None = None) -> Ended:
        """Run a command to its end; `file_size` [B] is the most that it can write into a file.

        Raises
        ------
        subprocess.TimeoutExpired
            Where it hangs.
        """
        first = "" if file_size is None else _SMALL_FILES.format(size=file_size)
        return ended(ghostball(arguments, self._environment, first), PATIENCE)

    def start(self, arguments: Sequence[str]) -> AbstractContextManager[subprocess.Popen[str]]:
        """Start a command; what is left of it ends with the block."""
        return ghostball(arguments, self._environment)


@dataclass(frozen=True)
class Asked:
    """What a command is asked for: some moments on some engines.

    Attributes
    ----------
    command : "validate" or "stress"
    engines : tuple of str
    count : int
        How many scenes, or trials (4 at most), each engine gets.
    jobs : int
    """

    command: Command
    engines: tuple[str, ...]
    count: int
    jobs: int = 1

    @property
    def names(self) -> list[str]:
        """Scenes, or trials."""
        if self.command == "validate":
            return [f"roll-{k}" for k in range(self.count)]
        return list(_STRESS_TRIALS[: self.count])

    @property
    def results(self) -> set[tuple[str, str]]:
        """What there is a result of in the end: scene or trial, and engine."""
        return {(name, label) for name in self.names for label in self.engines}

    def arguments(self, place: Place) -> list[str]:
        """Return the command line; scenes are written into the place."""
        return [
            self.command,
            *(self._given(name, place) for name in self.names),
            *("--engines", ",".join(self.engines)),
            *("--out", str(place.out)),
            *("--jobs", str(self.jobs)),
            *("--time-limit", str(TIME_LIMIT)),
            "--no-report",
        ]

    def _given(self, name: str, place: Place) -> str:
        if self.command == "stress":
            return f"grazing/{name}"
        path = place.folder / f"{name}.toml"
        path.write_text(_TOML.format(name=name), encoding="utf-8")
        return str(path)

    def outcomes(self, place: Place) -> Outcomes:
        """Return what the folder of results says.

        Raises
        ------
        ResultsError
            Where it can't be read.
        """
        if self.command == "validate":
            return {
                (one.scene, one.label): (one.outcome, one.reason)
                for one in ResultsFolder.load(place.out).cases
            }
        return {
            (one.trial, one.label): (one.outcome, "; ".join(one.faults))
            for one in StressFolder.load(place.out).findings
        }
