"""Section about generated shots: results of a run of `ghostball stress` in the same folder."""

from __future__ import annotations

from markupsafe import Markup

from ghostball.reports.page.rendering import render
from ghostball.reports.words import many
from ghostball.validation.results.store import Results, has_results
from ghostball.validation.stress import FAMILIES, path_of
from ghostball.validation.stress.tally import (
    FamilyTally,
    again,
    are_stress,
    sweeps,
    tallies,
    why_failed,
)

FOLDER = "stress"
"""Subfolder of a results folder with a run of `ghostball stress`."""


def stress_html(results: Results) -> Markup:
    """Return the results of the stress run; "" if the results folder has no stress run."""
    folder = results.path / FOLDER
    if not (folder.is_dir() and has_results(folder)):
        return Markup()
    run = Results.open(folder)
    if not are_stress(run.cases):
        return Markup()
    found, labels = tallies(run.cases), run.labels
    families = list(dict.fromkeys(family for family, _ in found))
    return render(
        "stress.html",
        shots=many(len(run.scene_names), "shot"),
        cpu=run.environment.get("cpu", "unknown machine"),
        date=str(run.environment.get("date", ""))[:10],
        whole=run.state == "complete",
        labels=labels,
        tallies=found,
        none=FamilyTally(),
        sweeps=sweeps(run.cases),
        families={name: FAMILIES[name] for name in families},
        path_of=path_of,
        why_failed=why_failed,
        again=again,
    )
