"""What was survived, counted: how often, and which case was the worst."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from ghostball.validation.stress.findings import WORST_FOLDER, Finding, StressFolder, stem_of


@dataclass(frozen=True)
class Survival:
    """How an engine came through a family.

    Attributes
    ----------
    worst : Finding or None
        Of those with a shot that shows them: what broke worst, else what came nearest.
    """

    family: str
    label: str
    findings: tuple[Finding, ...]
    worst: Finding | None

    @property
    def survived(self) -> int:
        """How many trials it survived."""
        return self._count("survived")

    @property
    def broken(self) -> int:
        """How many it did not."""
        return self._count("broken")

    @property
    def tried(self) -> int:
        """How many it could be asked: the others say nothing of it."""
        return self.survived + self.broken

    @property
    def not_representable(self) -> int:
        """How many trials have something that the engine lacks."""
        return self._count("not-representable")

    @property
    def unavailable(self) -> int:
        """How many could not be tried, since the engine can't run here."""
        return self._count("unavailable")

    @property
    def failed(self) -> int:
        """How many trials the harness failed to judge."""
        return self._count("failed")

    @property
    def shots(self) -> int:
        """How many shots were judged."""
        return sum(one.shots for one in self.findings)

    @property
    def broken_shots(self) -> int:
        """How many of them broke."""
        return sum(one.broken for one in self.findings)

    @property
    def seconds(self) -> float:
        """Wall time of all trials [s]."""
        return sum(one.seconds for one in self.findings)

    @property
    def text(self) -> str:
        """Survived and tried, as tables show it: "3/4"; or why there is no such number."""
        if self.failed:
            return f"{self.survived}/{self.tried}, {self.failed} not judged"
        if self.tried:
            return f"{self.survived}/{self.tried}"
        return "unavailable" if self.unavailable else "–"

    def failures(self) -> list[Finding]:
        """Return what the harness failed to judge."""
        return [one for one in self.findings if one.outcome == "failed"]

    def breaks(self) -> list[Finding]:
        """Return what broke, the worst first."""
        broken = [one for one in self.findings if one.outcome == "broken"]
        return sorted(broken, key=lambda one: -one.severity)

    def command(self, folder: Path) -> str | None:
        """Return the command that plays the worst case again; None where there is none.

        Parameters
        ----------
        folder : Path
            Of the stress run.
        """
        return None if self.worst is None else reproducing(self.worst, folder)

    def again(self, folder: StressFolder) -> str | None:
        """Return the command that tries the worst case again, and judges it; None: there is none.

        Of what broke, where nothing of it has a shot to be played, that is the worst of all.
        """
        worst = next(iter(self.breaks()), None) if self.worst is None else self.worst
        return None if worst is None else trying_again(worst, folder)

    def _count(self, outcome: str) -> int:
        return sum(one.outcome == outcome for one in self.findings)


def survival_of(folder: StressFolder, family: str, label: str) -> Survival:
    """Return how an engine came through a family."""
    found: Sequence[Finding] = folder.of(family, label)
    return Survival(family, label, tuple(found), folder.worst(family, label))


def all_survival(folder: StressFolder) -> Iterator[Survival]:
    """Yield each family and engine of a run that something is known of, family by family."""
    for family in folder.run.families:
        for label in folder.run.labels:
            one = survival_of(folder, family, label)
            if one.findings:
                yield one


def scene_file(worst: Finding, folder: Path) -> Path:
    """Return the file that a worst case's scene is kept in."""
    return folder / WORST_FOLDER / f"{stem_of(worst.family, worst.label)}.toml"


def reproducing(worst: Finding, folder: Path) -> str:
    """Return the command that plays a worst case again, and prints what becomes of it."""
    scene = shlex.quote(str(scene_file(worst, folder)))
    return f"ghostball run {scene} --engine {shlex.quote(worst.label)}"


def trying_again(finding: Finding, folder: StressFolder) -> str:
    """Return the command that tries a trial again and judges it, in a folder beside the run's."""
    trial = shlex.quote(f"{finding.family}/{finding.trial}")
    beside = shlex.quote(str(folder.path.with_name(folder.path.name + "-again")))
    engine = shlex.quote(finding.label)
    full = "--full " if folder.run.suite == "full" else ""
    return f"ghostball stress {trial} {full}--engine {engine} --rerun --out {beside}"
