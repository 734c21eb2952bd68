"""What engines survived of the stress suite, where such a run lies beside the results."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from markupsafe import Markup

from ghostball.reports.page.rendering import render
from ghostball.reports.words import many
from ghostball.validation.results.store import Results
from ghostball.validation.stress import FAMILIES, StressFolder
from ghostball.validation.stress.families.tunnelling import DEPTH, SPEED
from ghostball.validation.stress.findings import is_stress_folder
from ghostball.validation.stress.survival import (
    Survival,
    all_survival,
    tracked_numbers,
    trying_again,
)

STRESS_FOLDERS = ("stress", "stress-quick", "stress-full")
"""Where in a results folder a stress run may lie."""


def stress_html(results: Results) -> Markup:
    """Return what engines survived; "" where no stress run lies in the results folder."""
    folders = stress_folders(results.path)
    if not folders:
        return Markup()
    shot = f"{SPEED:g} m/s, {DEPTH:g} diameters of overlap"
    return render("stress.html", runs=map(_run, folders), shot=shot)


def stress_folders(path: Path) -> list[StressFolder]:
    """Return the stress runs in a results folder."""
    return [
        StressFolder.load(path / name) for name in STRESS_FOLDERS if is_stress_folder(path / name)
    ]


def _run(folder: StressFolder) -> dict[str, Any]:
    run, environment = folder.run, folder.run.environment
    found = list(all_survival(folder))
    return {
        "name": folder.path.name,
        "suite": run.suite,
        "done": many(len(folder.findings), "trial"),
        "planned": folder.planned,
        "whole": folder.whole,
        "cpu": environment.get("cpu", "unknown machine"),
        "date": str(environment.get("date", ""))[:10],
        "labels": run.labels,
        "families": [
            (_title(family), [Survival(folder, family, label) for label in run.labels])
            for family in run.families
        ],
        "unjudged": [
            (_title(one.family), one.label, failed, trying_again(failed, folder))
            for one in found
            for failed in one.of("failed")
        ],
        "worst": [_worst(one) for one in found if one.count("broken")],
        "tracked": tracked_numbers(folder),
        "asked": [FAMILIES[name] for name in run.families if name in FAMILIES],
    }


def _worst(one: Survival) -> dict[str, Any]:
    """Return the worst case of a family and engine that broke, and how to see it again."""
    worst = one.of("broken")[0] if one.worst is None else one.worst
    return {
        "family": _title(one.family),
        "label": one.label,
        "shots": f"{sum(found.broken for found in one.findings)} of "
        f"{sum(found.shots for found in one.findings)}",
        "trial": worst.trial,
        "fault": worst.faults[0] if worst.faults else "",
        "seen": one.command,
        "judged": one.again,
    }


def _title(family: str) -> str:
    known = FAMILIES.get(family)
    return family if known is None else known.title
