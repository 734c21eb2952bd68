"""What was survived, counted: how often, and which case was the worst."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from ghostball.validation.stress.families.tunnelling import DEPTH, SPEED
from ghostball.validation.stress.findings import (
    WORST_FOLDER,
    Finding,
    Outcome,
    StressFolder,
    stem_of,
)


@dataclass(frozen=True)
class Survival:
    """How an engine came through a family."""

    folder: StressFolder
    family: str
    label: str

    @cached_property
    def findings(self) -> list[Finding]:
        """What was found of the engine in the family."""
        return self.folder.of(self.family, self.label)

    @property
    def worst(self) -> Finding | None:
        """Of what has a shot that shows it: what broke worst, else what came nearest."""
        return self.folder.worst(self.family, self.label)

    def of(self, outcome: Outcome) -> list[Finding]:
        """Return what came to an outcome, the worst first."""
        found = [one for one in self.findings if one.outcome == outcome]
        return sorted(found, key=lambda one: -one.severity)

    def count(self, *outcomes: Outcome) -> int:
        """Return how many trials came to one of these outcomes."""
        return sum(one.outcome in outcomes for one in self.findings)

    @property
    def tried(self) -> int:
        """How many trials the engine could be asked: the others say nothing of it."""
        return self.count("survived", "broken")

    @property
    def text(self) -> str:
        """Survived and tried, as tables show it: "3/4"; or why there is no such number."""
        survived = f"{self.count('survived')}/{self.tried}"
        if unjudged := self.count("failed", "not-judged"):
            return f"{survived}, {unjudged} not judged"
        if self.tried:
            return survived
        return "unavailable" if self.count("unavailable") else "–"

    @property
    def command(self) -> str | None:
        """The command that plays the worst case again; None where there is none."""
        if self.worst is None:
            return None
        scene = shlex.quote(str(scene_file(self.worst, self.folder.path)))
        return f"ghostball run {scene} --engine {shlex.quote(self.label)}"

    @property
    def again(self) -> str | None:
        """The command that tries the worst case again, and judges it; None where there is none.

        Of what broke, where nothing of it has a shot to be played, that is the worst of all.
        """
        worst = next(iter(self.of("broken")), None) if self.worst is None else self.worst
        return None if worst is None else trying_again(worst, self.folder)


def all_survival(folder: StressFolder) -> Iterator[Survival]:
    """Yield each family and engine of a run that something is known of, family by family."""
    for family in folder.run.families:
        for label in folder.run.labels:
            one = Survival(folder, family, label)
            if one.findings:
                yield one


def scene_file(worst: Finding, folder: Path) -> Path:
    """Return the file that a worst case's scene is kept in."""
    return folder / WORST_FOLDER / f"{stem_of(worst.family, worst.label)}.toml"


def trying_again(finding: Finding, folder: StressFolder) -> str:
    """Return the command that tries a trial again and judges it, in a folder beside the run's."""
    trial = shlex.quote(f"{finding.family}/{finding.trial}")
    beside = shlex.quote(str(folder.path.with_name(folder.path.name + "-again")))
    engine = shlex.quote(finding.label)
    full = "--full " if folder.run.suite == "full" else ""
    return f"ghostball stress {trial} {full}--engine {engine} --rerun --out {beside}"


def tracked_numbers(folder: StressFolder) -> list[dict[str, Any]]:
    """Return the largest step [s] without a miss of each engine that has a ladder of steps.

    As plain values, with whether a larger step misses: an engine is tracked by it from run to run.
    """
    return [
        {
            "engine": one.label,
            "own_step": one.values["step"],
            "largest_step_without_a_miss": one.values["largest_step"],
            "larger_steps_miss": any(rung["missed"] for rung in one.values["ladder"]),
        }
        for one in folder.findings
        if "ladder" in one.values
        and (one.values.get("speed"), one.values.get("depth")) == (SPEED, DEPTH)
    ]
